"""Never in a library: d follows the ceramic's temperature, which has a course of its own.

    w -> w (1 + strength T(t)),   T slow noise of unit variance

(d33 of soft ceramics changes by some tenths of a per cent per kelvin).
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


def with_temperature(amount: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    course = slow_course(around.generator(), -around.past, around.duration, 1.0 / given["period"])

    def run(block: Block) -> None:
        block.signal *= 1.0 + amount * course(block.times)

    return Element(Slot.FREE, run)


EFFECT = Effect(
    "thermal_gain",
    "material",
    False,
    (
        Form(
            "b",
            "d follows a temperature",
            strength("1", 0.01, 0.2, "standard deviation of d over its mean"),
            (shape("period", "s", 6.0, 20.0, "of the fastest change"),),
            with_temperature,
            repeatable=False,
        ),
    ),
)
