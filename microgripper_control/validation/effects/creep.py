"""Creep of the ceramic.

a: the logarithmic law, which for a step reads x(t) = x0 (1 + c ln(1 + t / onset)) (Jung and Gweon,
   Rev. Sci. Instrum. 71, 2000), superposed over the past so that it holds for any course.
b: a fractional-order element: after a step creep grows as t^order (Liu et al., "On the modelling of
   piezoceramic creep by fractional order", Smart Mater. Struct. 19, 2010), a little more where the
   field is high.
Strength a: growth for each factor e in time; b: growth after one second; both as a share of what
the stack moves freely.
"""

from __future__ import annotations

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
from microgripper_control.validation.relaxations import (
    gains,
    logarithmic,
    march_relaxations,
    power_law,
    rates,
)


def _creeping(weights: Array, field: float, around: Surroundings) -> Element:
    gain, state = gains(around.step), rates() * 0.0
    free_stroke = around.scale.stroke * around.scale.base.stiffness / around.scale.base.k

    def run(block: Block) -> None:
        drive = block.signal * (1.0 + field * abs(block.signal) / free_stroke)
        march_relaxations(gain, weights, state, drive, block.signal)

    return Element(Slot.FREE, run)


def logarithmic_creep(growth: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    return _creeping(growth * logarithmic(given["onset"]), 0.0, around)


def fractional_creep(growth: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    return _creeping(growth * power_law(given["order"]), given["field"], around)


def in_holds(growth: float, given: Shape, reach: Reach) -> list[Place]:
    """From a tenth of a second, when all else has settled, to the longest hold."""
    return [Place("hold_time_s", 0.1, reach.hold)] if reach.hold > 0.2 else []


EFFECT = Effect(
    "creep",
    "material",
    True,
    (
        Form(
            "a",
            "logarithmic in the time since each change",
            strength("1", 0.005, 0.2, "growth for each factor e in time"),
            (shape("onset", "s", 0.002, 0.1, "when the law begins"),),
            logarithmic_creep,
            in_holds,
        ),
        Form(
            "b",
            "a power of the time since each change, more at high field",
            strength("1", 0.01, 0.4, "growth one second after a step"),
            (
                shape("order", "1", 0.1, 0.3, "exponent of the time"),
                shape("field", "1", 0.0, 0.4, "more of it at full stroke"),
            ),
            fractional_creep,
            in_holds,
        ),
    ),
)
