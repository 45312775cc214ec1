"""Friction in guide or joint: it sticks like a spring, slips at a force that depends on speed.

    F = -f - damping z',    f = stiffness z,
    z' = x' (1 - r) (1 + bend r)      while it is loaded further, r >= 0,
    z' = x' (1 - recovery r)          on the way back, r < 0,
    r = sgn(x') f / g,    g = coulomb (1 + excess / (1 + (x'/v_s)^2))

and, of the share that is `distributed`,

    f = sum_i k_i s_i,    s_i follows x, but never leaves -w_i .. w_i.

At bend 0 and recovery 1 this is Dahl's bristle. `bend` keeps it stiff until shortly before it
slips, and a small `recovery` lets it come back along its own stiffness, as the elasto-plastic
bristle of Dupont does; the breakaway force is Stribeck's as in LuGre, and with an excess below zero
it grips the more the faster it slides, as grease does. At excess 0 it depends on the path alone, in
closed form; with excess, g is taken at the mean speed of a step. What sticks may damp while it
bends, LuGre's sigma_1: that is seen where the rig rings from sample to sample. LuGre's viscous term
is not repeated: the mechanics' b is one.

That part is a Maxwell slip: asperities that slip at distances of their own, so that it
remembers each turn of the way (`effects.slipping_springs`). The distances are such that all slip at
`coulomb`.
"""

import math
from collections.abc import Collection, Mapping, Sequence

from microgripper_control.core.compiled import compiled, inlined
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values
from microgripper_control.effects.memory_of_the_way import RELEASED, released, unusually_long
from microgripper_control.effects.slipping_springs import (
    SPREAD,
    SPRINGS,
    all_slipped,
    pull,
    springs,
)

RINGING = 6.0  # swings of the rig's own from sample to sample, after which none is left to see
DAMPED = 0.3  # a first guess at the damping, over sqrt(stiffness mass)
STUCK = 5.0  # times as stiff as the rig: it hardly moves then,
BIT_BY_BIT = {"decades": 1.0, "taper": 0.5}  # and lets go
SLIGHT = 0.1  # so far e^-x is taken as (12 - 6 x + x^2) / (12 + 6 x + x^2)


@compiled
def forgotten(x: float) -> float:
    """1 - e^-x."""
    if abs(x) < SLIGHT:
        return float(12.0 * x / (12.0 + x * (x + 6.0)))
    return -math.expm1(-x)


@inlined
def _follows(r: float, bend: float, recovery: float) -> float:
    """The share of a way that goes into bending the bristle."""
    return 1.0 - recovery * r if r < 0.0 else (1.0 - r) * (1.0 + bend * r)


@compiled
def bristle(r: float, x: float, bend: float, recovery: float) -> float:
    """r after a way of x > 0, in bristle lengths, in one direction."""
    if r < 0.0:
        back = 1.0 - recovery * r
        change = back * (x if recovery == 0.0 else forgotten(recovery * x) / recovery)
        if r + change <= 0.0:
            return r + change
        x -= -r if recovery == 0.0 else math.log(back) / recovery
        r = 0.0
    loaded, more, lost = 1.0 - r, 1.0 + bend * r, forgotten((1.0 + bend) * x)
    return r + loaded * more * lost / ((1.0 + bend) * (1.0 - lost) + more * lost)


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    way = x1 - x0
    slipping = pull(c, 8, before, after, 1, way) if c[6] > 0.0 else 0.0
    f: float = before[0]
    braking = 0.0
    if way != 0.0 and c[6] < 1.0:
        run, scale = way * way, (step * c[3]) * (step * c[3])
        level = c[0] * (run + (1.0 + c[2]) * scale) / (run + scale)
        if level > 0.0:
            ahead = level if way > 0.0 else -level
            r = bristle(f / ahead, abs(way) * c[1] / level, c[4], c[5])
            f, braking = ahead * r, c[7] * v * _follows(r, c[4], c[5])
        else:
            f = 0.0
    after[0] = f
    force: float = (1.0 - c[6]) * (f + braking) + slipping
    return -force


def coefficients(values: Values) -> Sequence[float]:
    names = ("coulomb", "stiffness", "excess", "stribeck_speed", "bend", "recovery")
    limits, shares = springs(widest(values), values["decades"], values["taper"])
    share = values["distributed"]
    return [
        *(values[name] for name in names),
        share,
        values["damping"],
        *limits,
        *(share * values["stiffness"] * shares),
    ]


def widest(values: Values) -> float:
    """The distance, m, at which the last spring slips."""
    slipped = all_slipped(values["decades"], values["taper"])
    return values["coulomb"] / (values["stiffness"] * slipped)


def stiffness(values: Values) -> float:
    return values["stiffness"]


def damping(values: Values) -> float:
    return (1.0 - values["distributed"]) * values["damping"]


def starts(scales: Scales) -> Sequence[Values]:
    """A hundredth of the rig's force, which sticks over more or less of the stroke.

    What sticks damps where the rig's own ringing reaches from sample to sample; elsewhere a damping
    would hardly leave a trace.
    """
    force = 0.01 * scales.stiffness * scales.stroke
    swing = 2.0 * math.pi * math.sqrt(scales.mass / scales.stiffness)
    rings = scales.sample_period < RINGING * swing
    found: list[Values] = []
    for share in (0.003, 0.02, 0.15):
        stiffness = force / (share * scales.stroke)
        damping = DAMPED * math.sqrt(stiffness * scales.mass) if rings else 0.0
        begun = {"coulomb": force, "stiffness": stiffness, "excess": 0.0}
        found += [
            begun | {"bend": 0.0, "recovery": 1.0, "damping": damping},
            begun | {"bend": 2.0, "recovery": 0.1, "damping": damping},
            begun | {"distributed": 1.0},
        ]
    return found


def likened(other: str, values: Values, scales: Scales) -> Values:
    """A Bouc-Wen force with n = 1 is Dahl's bristle, springs that slip are the same.

    With n = 2 it stays stiff for longer. What sticks while the actuator goes on looks like play.
    """
    if other == "backlash" and values["play"] > 0.0:
        behind = 0.5 * values["play"] * (1.0 - 0.5 * values["spread"])  # m, when all is taken up
        stiff = {"stiffness": STUCK * scales.stiffness, "distributed": 1.0}
        return {"coulomb": behind * scales.stiffness, **stiff, **BIT_BY_BIT}
    if other != "restoring_force_hysteresis" or values["alpha"] <= 0.0:
        return {}
    alpha = values["alpha"]
    if values["distributed"] == 1.0:
        coulomb = alpha * values["widest"] * all_slipped(values["decades"], values["taper"])
        return {"coulomb": coulomb, "stiffness": alpha, **{name: values[name] for name in SPREAD}}
    forgetting = values["beta"] + values["gamma"]
    if forgetting <= 0.0:
        return {}
    most = (alpha / forgetting) ** (1.0 / values["n"])
    bend = values["n"] - 1.0
    return {"coulomb": most, "stiffness": alpha, "bend": bend, "recovery": 1.0, "excess": 0.0}


def idle(values: Values) -> Collection[str]:
    """Of the part that is not there; a damping that has not been begun with stays away."""
    without = {0.0: ("decades", "taper"), 1.0: ("bend", "recovery", "excess")}
    undamped = () if values["damping"] else ("damping",)
    return (*without.get(values["distributed"], ()), *undamped)


def presliding(values: Values) -> float:
    """The way, m, for which it holds after a reversal."""
    bristle = values["coulomb"] * (1.0 + values["excess"]) / values["stiffness"]
    share = values["distributed"]
    return (1.0 - share) * bristle + share * widest(values)


def says(values: Values, scales: Scales) -> str:
    held = quantity(presliding(values), "m")
    return (
        f"there is friction: after each reversal it holds for about {held}, "
        f"then slides against {quantity(values['coulomb'], 'N')}"
    )


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """Ten times stiffer than the rig is just stuck: no recording tells more.

    Nor of a damping that alone would keep the rig from ringing.
    """
    critical = 2.0 * math.sqrt(scales.stiffness * scales.mass)
    return {
        "stiffness": (1e-3 * scales.stiffness, 10.0 * scales.stiffness),
        "damping": (0.0, critical),
    }


def unusual(values: Values, scales: Scales) -> float:
    """What bends over a good part of the stroke is hysteresis of the restoring force."""
    return unusually_long(presliding(values), scales)


LINK = Link(
    name="friction",
    stage=Stage.MECHANICS,
    order=30,
    title="friction in guide or joint",
    source=(
        "Dahl 1968; Canudas de Wit et al. 1995 (LuGre); Dupont et al. 2002 (elasto-plastic); "
        "Lampaert, Al-Bender and Swevers 2003 (Maxwell slip)"
    ),
    force=Force(
        law, coefficients, stiffness, states=1 + SPRINGS, damping=damping, released=released
    ),
    parameters=(
        Parameter("coulomb", "N", 10.0, 0.0, 1e6, "friction force when sliding", 0.0),
        Parameter("stiffness", "N/m", 2e7, 1.0, 1e13, "stiffness of what sticks, before it slides"),
        Parameter("bend", "1", 0.0, 0.0, 10.0, "how long it stays stiff before it slips"),
        Parameter(
            "recovery", "1", 1.0, 0.0, 2.0, "how soon a slipped bristle softens on the way back"
        ),
        Parameter("damping", "N*s/m", 0.0, 0.0, 1e6, "of what sticks, while it bends"),
        Parameter("distributed", "1", 0.0, 0.0, 1.0, "share that slips bit by bit", fitted=False),
        Parameter("decades", "1", 0.5, 0.0, 3.0, "decades over which the distances are spread"),
        Parameter("taper", "1", 0.0, -5.0, 3.0, "how much stiffer what slips early is"),
        Parameter("excess", "1", 0.2, -0.95, 5.0, "excess of breaking away over sliding, a share"),
        Parameter(
            "stribeck_speed",
            "m/s",
            1e-4,
            1e-9,
            10.0,
            "speed over which the excess goes",
            fitted=False,
        ),
        RELEASED,
    ),
    starts=starts,
    likened=likened,
    idle=idle,
    plausible=plausible,
    unusual=unusual,
    says=says,
)
