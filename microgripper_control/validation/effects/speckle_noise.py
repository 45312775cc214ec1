"""Never in a library: noise that grows with the displacement and is not white.

A laser's speckle moves with the surface: reading + strength y n(t), n slow noise of unit variance
(Dorsch, Hausler and Herrmann, Appl. Opt. 33, 1994). No input explains it.
"""

from __future__ import annotations

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


def speckle(amount: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    course = slow_course(around.generator(), -around.past, around.duration, given["corner"])

    def run(block: Block) -> None:
        block.signal += amount * block.signal * course(block.times)

    return Element(Slot.READING, run)


EFFECT = Effect(
    "speckle_noise",
    "sensor",
    False,
    (
        Form(
            "b",
            "coloured noise in proportion to the displacement",
            strength("1", 0.002, 0.1, "standard deviation over the displacement"),
            (shape("corner", "Hz", 3.0, 20.0, "of the noise"),),
            speckle,
            repeatable=False,
        ),
    ),
)
