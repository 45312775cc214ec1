"""Finite resolution.

a: a converter with integral nonlinearity: its thresholds bow off the ideal ones by up to 0.35 of a
   step over some tens of codes (IEEE Std 1241-2010).
b: a counter with hysteresis, as in encoders and fringe counters: it moves on only when the position
   is more than 0.5 + dead steps away from the count.
Strength: the step, in m.
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
def march_count(p: Array, state: Array, readings: Array) -> None:
    """p: step in m, dead; state: count."""
    count = state[0]
    for j in range(len(readings)):
        away = readings[j] / p[0] - count
        if abs(away) > 0.5 + p[1]:
            count = floor(readings[j] / p[0] + 0.5)
        readings[j] = p[0] * count
    state[0] = count


def counter(size: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    numbers = np.array([size, given["dead"]])
    state = np.zeros(1)

    def run(block: Block) -> None:
        march_count(numbers, state, block.signal)

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
            "counter with hysteresis",
            strength("m", 6e-8, 1e-5, "one step"),
            (shape("dead", "1", 0.1, 0.4, "beyond half a step before it counts, in steps"),),
            counter,
            repeatable=False,
        ),
    ),
)
