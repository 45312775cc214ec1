"""Friction in guide or joint: it sticks like a spring, slips at a force that falls with speed.

    F = -f,    f' = stiffness (x' - |x'| f / g),    g = coulomb (1 + excess / (1 + (x'/v_s)^2))

The bristle model of Dahl, with the breakaway force of Stribeck as in LuGre. At excess 0 it depends
on the path alone, in closed form; with excess, g is taken at the mean speed of a step. LuGre's
viscous term is not repeated: the mechanics' b is one.
"""

import math
from collections.abc import Mapping, Sequence

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values

SLIGHT = 0.1  # of the bristle's length: so far the approximation is within 2e-7 of the change


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    way = x1 - x0
    run, scale = way * way, (step * c[3]) * (step * c[3])
    # The bristle relaxes over the way by exp(-bent / level).
    bent, level = c[1] * abs(way) * (run + scale), c[0] * (run + (1.0 + c[2]) * scale)
    f: float = before[0]
    if bent < SLIGHT * level:  # Pade: a division is what costs here, and this takes one
        pull = c[1] * way * level - f * bent
        f += pull * level / (level * level + bent * (level * (1 / 2) + bent * (1 / 12)))
    elif bent > 0.0:
        x = bent / level
        f += (c[1] * way / x - f) * (1.0 - math.exp(-x))
    after[0] = f
    return -f


def coefficients(values: Values) -> Sequence[float]:
    return values["coulomb"], values["stiffness"], values["excess"], values["stribeck_speed"]


def stiffness(values: Values) -> float:
    return values["stiffness"]


def starts(scales: Scales) -> Sequence[Values]:
    """A hundredth of the rig's force, which sticks over more or less of the stroke."""
    force = 0.01 * scales.stiffness * scales.stroke
    return [
        {"coulomb": force, "stiffness": force / (share * scales.stroke), "excess": 0.0}
        for share in (0.01, 0.05, 0.2)
    ]


def says(values: Values, scales: Scales) -> str:
    held = values["coulomb"] * (1.0 + values["excess"]) / values["stiffness"]
    return (
        f"there is friction: after each reversal it holds for about {quantity(held, 'm')}, "
        f"then slides against {quantity(values['coulomb'], 'N')}"
    )


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """What sticks stiffer than the rig itself just sticks: no recording tells how stiff."""
    return {"stiffness": (1e-3 * scales.stiffness, scales.stiffness)}


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
    starts=starts,
    plausible=plausible,
    says=says,
)
