"""Slow drift that the voltage does not explain.

a: frame and sensor follow a change of the room's temperature, each with its own time constant, and
   the room's regulation swings a little (two-body lumped model, Slocum, Precision Machine Design,
   1992, ch. 2).
b: a random walk of the air's temperature through the thermal mass of the mount.
Each recording has a course of its own. Strength: the size of the drift over a recording, in m.
"""

from __future__ import annotations

from math import exp, pi

import numpy as np

from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.effects.form import (
    Effect,
    Element,
    Form,
    Place,
    Reach,
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)

SPACING = 0.02  # s, grid of the random walk
SWING = 0.15  # of the room's regulation


def two_bodies(size: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    generator = around.generator()
    lift = generator.choice([-1.0, 1.0]) * generator.uniform(0.7, 1.3) * size
    phase = generator.uniform(0.0, 2.0 * pi)

    def course(t: Array) -> Array:
        frame = 1.0 - np.exp(-t / given["frame"])
        sensor = 1.0 - np.exp(-t / (given["ratio"] * given["frame"]))
        swing = np.sin(2.0 * pi * t / given["period"] + phase) - np.sin(phase)
        drift: Array = lift * (0.6 * frame + 0.8 * sensor + SWING * swing)
        return drift

    def run(block: Block) -> None:
        block.signal += course(np.maximum(block.times, 0.0))

    return Element(Slot.READING, run)


def random_walk(size: float, given: Shape, around: Surroundings) -> Element:
    """Form b: scaled so that it has moved by `size`, rms over all walks, after the recording."""
    generator = around.generator()
    times = SPACING * np.arange(int(around.duration / SPACING) + 3)
    walk = np.cumsum(generator.standard_normal(len(times))) / np.sqrt(len(times))
    keep = exp(-SPACING / given["mass"])
    values = np.empty_like(walk)
    value = 0.0
    for j, target in enumerate(walk):
        value = keep * value + (1.0 - keep) * target
        values[j] = value

    def run(block: Block) -> None:
        block.signal += size * np.interp(block.times, times, values)

    return Element(Slot.READING, run)


def slow(size: float, given: Shape, reach: Reach) -> list[Place]:
    """Below the fastest swing."""
    return [Place("frequency_Hz", 0.0, 0.2)]


EFFECT = Effect(
    "thermal_drift",
    "sensor",
    True,
    (
        Form(
            "a",
            "frame and sensor follow a change of the room, which swings",
            strength("m", 6e-8, 2e-5, "drift when all is warm, about"),
            (
                shape("frame", "s", 5.0, 20.0, "time constant of the frame"),
                shape("ratio", "1", 3.0, 10.0, "time constant of the sensor over the frame's"),
                shape("period", "s", 15.0, 60.0, "of the room's regulation"),
            ),
            two_bodies,
            slow,
            repeatable=False,
        ),
        Form(
            "b",
            "random walk of the air through a thermal mass",
            strength("m", 1e-7, 2e-5, "standard deviation over walks after the recording"),
            (shape("mass", "s", 1.0, 6.0, "time constant of the mount"),),
            random_walk,
            slow,
            repeatable=False,
        ),
    ),
)
