"""Friction in guide or joint: it sticks like a spring, slips at a force that falls with speed.

    F = -f,    f' = stiffness (x' - |x'| f / g),    g = coulomb (1 + excess / (1 + (x'/v_s)^2))

The bristle model of Dahl, with the breakaway force of Stribeck as in LuGre. At excess 0 it depends
on the path alone and has the closed form of Bouc-Wen at gamma = 0; with excess, g is taken at the
mean speed of a step. LuGre's viscous term is not repeated: the mechanics' b is one.
"""

from collections.abc import Sequence

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Stage, Values
from microgripper_control.effects.material.bouc_wen import advance


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    speed = (x1 - x0) / (step * c[3])
    level = c[0] * (1.0 + c[2] / (1.0 + speed * speed))
    f = advance(before[0], x1 - x0, c[1], c[1] / level, 0.0, 1.0)
    after[0] = f
    return -f


def coefficients(values: Values) -> Sequence[float]:
    return values["coulomb"], values["stiffness"], values["excess"], values["stribeck_speed"]


def stiffness(values: Values) -> float:
    return values["stiffness"]


LINK = Link(
    name="friction",
    stage=Stage.MECHANICS,
    order=30,
    title="friction in guide or joint",
    source="Dahl 1968; Canudas de Wit, Olsson, Astrom, Lischinsky 1995 (LuGre)",
    force=Force(law, coefficients, stiffness, states=1),
    parameters=(
        Parameter("coulomb", "N", 10.0, 0.0, 1e6, "friction force when sliding", 0.0),
        Parameter("stiffness", "N/m", 2e7, 1.0, 1e13, "of what sticks, before it slides"),
        Parameter("excess", "1", 0.2, 0.0, 5.0, "of breaking away over sliding, a share"),
        Parameter(
            "stribeck_speed", "m/s", 1e-4, 1e-9, 10.0, "over which the excess goes", fitted=False
        ),
    ),
)
