"""Finite resolution.

a: a converter with integral nonlinearity: its thresholds bow off the ideal ones by up to 0.35 of a
   step over some tens of codes (IEEE Std 1241-2010).
b: a gain-ranging converter: the amplifier before it doubles its gain whenever the position fits
   into half of the range, three times at most, and each time the step is halved (Kester, The Data
   Conversion Handbook, 2005, on programmable gain before converters).
Strength: the step, in m; b: that of the widest range.
"""

from __future__ import annotations

from math import floor, pi, sin

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.effects.form import (
    Effect,
    Element,
    Form,
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)

DOUBLINGS = 3  # of the gain


@compiled
def convert(p: Array, readings: Array) -> None:
    """p: step in m, phase, bow in steps, its period in codes."""
    for j in range(len(readings)):
        codes = readings[j] / p[0]
        bow = p[2] * sin(2.0 * pi * (codes / p[3] + p[1]))
        readings[j] = p[0] * (floor(codes + bow + p[1]) + 0.5 - p[1])


def bowed_converter(size: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    numbers = np.array([size, given["phase"], given["bow"], given["period"]])

    def run(block: Block) -> None:
        convert(numbers, block.signal)

    return Element(Slot.CONVERTER, run)


@compiled
def convert_in_ranges(p: Array, readings: Array) -> None:
    """p: step of the widest range in m, displacement from which on it is needed in m."""
    for j in range(len(readings)):
        step, needed = p[0], p[1]
        for _ in range(DOUBLINGS):
            if abs(readings[j]) >= needed:
                break
            step, needed = 0.5 * step, 0.5 * needed
        readings[j] = step * floor(readings[j] / step + 0.5)


def gain_ranging(size: float, given: Shape, around: Surroundings) -> Element:
    """Form b; the ranges are centred on the rig's zero."""
    farthest = max(around.scale.top, -around.scale.bottom)
    numbers = np.array([size, given["widest"] * farthest])

    def run(block: Block) -> None:
        convert_in_ranges(numbers, block.signal)

    return Element(Slot.CONVERTER, run)


EFFECT = Effect(
    "sensor_quantization",
    "sensor",
    True,
    (
        Form(
            "a",
            "converter with bowed thresholds",
            strength("m", 6e-8, 1e-5, "one step"),
            (
                shape("phase", "1", 0.0, 1.0, "of the steps against the rig's zero"),
                shape("bow", "1", 0.1, 0.35, "of the thresholds, in steps"),
                shape("period", "1", 20.0, 60.0, "of the bow, in codes"),
            ),
            bowed_converter,
            repeatable=False,
        ),
        Form(
            "b",
            "gain-ranging converter, whose step doubles from range to range",
            strength("m", 6e-8, 1e-5, "one step of the widest range"),
            (shape("widest", "1", 0.4, 0.7, "begin of the widest range over the farthest way"),),
            gain_ranging,
            repeatable=False,
        ),
    ),
)
