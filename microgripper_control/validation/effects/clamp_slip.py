"""Never in a library: the clamp of the finger slips once during the recording.

From then on the finger stands elsewhere and a part of the motion is lost. Strength: the jump over
the stroke; the loss of gain is as large.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.validation.block import Block
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


def slipping_clamp(jump: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    instant = given["instant"] * around.duration

    def run(block: Block) -> None:
        slipped = np.where(block.times >= instant, jump, 0.0)
        block.signal -= slipped * (block.signal + around.scale.stroke)

    return Element(Slot.POSITION, run)


def at_instant(jump: float, given: Shape, reach: Reach) -> list[Place]:
    """From the slip to the end."""
    return [Place("time_s", given["instant"] * reach.duration, reach.duration)]


EFFECT = Effect(
    "clamp_slip",
    "transmission",
    False,
    (
        Form(
            "b",
            "the finger's clamp slips once",
            strength("1", 0.003, 0.3, "jump over the stroke"),
            (shape("instant", "1", 0.3, 0.7, "of the slip, share of the recording"),),
            slipping_clamp,
            at_instant,
        ),
    ),
)
