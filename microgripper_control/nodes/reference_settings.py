"""The reference's parameters, and the course of setpoints that they ask for.

One shape is described by parameters of the node (`shape: sine`, `frequency: 1.0`, ...). Several in
a row are named in `segments`, and each has its parameters under its name:

    segments: [stairs, wave]
    stairs: {shape: staircase, length: 10.0, low: 2.0e-6, high: 12.0e-6, steps: 5, hold: 1.0}
    wave: {shape: sine, length: 5.0, low: 2.0e-6, high: 12.0e-6, frequency: 1.0}
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rclpy.node import Node

from microgripper_control.control.setpoints import SETPOINTS, Sequence, Setpoint, read_recorded
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.parameters import Parameter
from microgripper_control.nodes.parameters import (
    declare_number,
    declare_path,
    declare_text,
    declare_texts,
)

CSV = "csv"
SHAPES = (*SETPOINTS, CSV)
LENGTH = Parameter("length", "s", 0.0, 0.0, 1e7, "of the shape; 0: endless, or as long as the CSV")


def declare_course(node: Node, sample_period: float) -> tuple[Setpoint, int | None]:
    """Declare what describes the setpoints: those, and how many there are if they end.

    Raises MicrogripperError naming what is wrong.
    """
    names = declare_texts(node, "segments", [], "names of the shapes that follow one another")
    if not names:
        setpoint, length = _declare_shape(node, "", sample_period)
        if length == 0.0:
            return setpoint, None
        course = Sequence(((setpoint, length),))
    else:
        shapes = [_declare_shape(node, f"{name}.", sample_period) for name in names]
        for name, (_, length) in zip(names, shapes, strict=True):
            if length == 0.0:
                raise MicrogripperError(f"{name}.length: a segment needs one; give it in s")
        course = Sequence(tuple(shapes))
    return course, course.boundaries(sample_period)[-1]


def _declare_shape(node: Node, prefix: str, sample_period: float) -> tuple[Setpoint, float]:
    """One shape and its length, s; 0 if it is endless."""
    name = declare_text(
        node, f"{prefix}shape", "sine", "form of the signal", choices=SHAPES, read_only=True
    )
    length = declare_number(node, replace(LENGTH, name=f"{prefix}length"), read_only=True)
    if name == CSV:
        file = declare_path(node, f"{prefix}file", "", "CSV with time_s")
        if file == Path():
            raise MicrogripperError(f"{prefix}file is empty: name a CSV, -p {prefix}file:=PATH")
        column = declare_text(node, f"{prefix}column", "", "the values' column", read_only=True)
        recorded = read_recorded(file, column or None)
        return recorded, length or float(recorded.times[-1]) + sample_period
    shape = SETPOINTS[name]
    values = {
        parameter.name: declare_number(
            node, replace(parameter, name=f"{prefix}{parameter.name}"), read_only=True
        )
        for parameter in shape.parameters()
    }
    return shape.from_values(values, f"{prefix}{name}"), length
