"""Never in a library: a neighbouring axis, which scans on its own, moves this one along.

The neighbour runs a triangle with rounded turns, a rate that no one recorded, and stops for a while
now and then. Strength: what this axis moves with it, peak to peak over the stroke.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.validation.block import Block
from microgripper_control.validation.chance import slow_course
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

ROUNDING = 0.9  # 1 would be a sharp triangle
RESTING = -0.7  # the slow course below which the neighbour stands
RESTS_CORNER = 0.1  # Hz
SPACING = 2e-3  # s


def scanning_neighbour(amount: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    generator = around.generator()
    begin, end = -around.past - 1.0, around.duration + 1.0
    start = generator.uniform(0.0, 1.0)
    rests = slow_course(generator, begin, end, RESTS_CORNER)
    times = np.arange(begin, end, SPACING)
    turns = start + given["rate"] * SPACING * np.cumsum(rests(times) > RESTING)
    triangle = np.arcsin(ROUNDING * np.sin(2.0 * np.pi * turns)) / np.arcsin(ROUNDING)
    motion = 0.5 * amount * around.scale.stroke * triangle

    def run(block: Block) -> None:
        block.signal += np.interp(block.times, times, motion)

    return Element(Slot.POSITION, run)


EFFECT = Effect(
    "cross_talk",
    "transmission",
    False,
    (
        Form(
            "a",
            "a neighbouring axis that scans",
            strength("1", 0.003, 0.3, "peak to peak over the stroke"),
            (shape("rate", "Hz", 0.4, 6.0, "of the neighbour's scan"),),
            scanning_neighbour,
            repeatable=False,
        ),
    ),
)
