"""Hysteresis in the restoring force: Bouc-Wen driven by the displacement, and Iwan's slip joint.

    F = -z - alpha distributed sum_i k_i s_i / sum_i k_i,
    z' = alpha (1 - distributed) x' - beta |x'| z |z|^(n-1) - gamma x' |z|^n

The first part is of the same family as the material's (effects/material/bouc_wen.py) with the
displacement in place of the voltage: a joint, a bond or a bearing whose force remembers the way and
is soon saturated. The public Bouc-Wen benchmark is this with alpha 5e4 N/m, beta 800 /m, gamma
-1100 /m, n 1, at distributed 0.

The second part softens bit by bit until `widest`, as a bolted joint does whose parts slip one after
the other: the springs of `effects.slipping_springs`.
"""

import math
from collections.abc import Collection, Mapping, Sequence

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent, quantity
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.effects.memory_of_the_way import RELEASED, released, unusually_short
from microgripper_control.effects.slipping_springs import (
    SPREAD,
    SPRINGS,
    all_slipped,
    pull,
    springs,
)

ELASTIC = 8.0  # |gamma| over beta: beyond it hardly anything is lost in a loop
FORGOTTEN = 3.0  # lengths over which 1 / e is left: after them a turn is forgotten
TINY = 1e-30


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    way = x1 - x0
    z = advance(before[0], way, c[0], c[1], c[2], c[3])
    after[0] = z
    force = -float(z)
    if c[4] == 0.0:
        return force
    return force - pull(c, 5, before, after, 1, way)


def coefficients(values: Values) -> Sequence[float]:
    alpha, distributed = values["alpha"], values["distributed"]
    bouc_wen = (alpha * (1.0 - distributed), values["beta"], values["gamma"], values["n"])
    limits, shares = springs(values["widest"], values["decades"], values["taper"])
    return (*bouc_wen, distributed, *limits, *(alpha * distributed * shares))


def stiffness(values: Values) -> float:
    return values["alpha"]


RATE_UNIT = "1/(m*N^(n-1))"


def starts(scales: Scales) -> Sequence[Values]:
    """Some of the stiffness, forgotten over more or less of the stroke; or all that slips.

    Either may be about as stiff as the rig: a fit does not get there from a seventh of it.
    """
    alpha = 0.02 * scales.stiffness
    ways = (scales.stroke, scales.stroke / 4.0, scales.stroke / 16.0)
    saturating = [
        {"alpha": alpha, "beta": 1.0 / way, "gamma": share / way}
        for way in ways
        for share in (-0.6, 0.0, 0.6)
    ]
    saturating += [{"alpha": 25.0 * alpha, "beta": 1.0 / way, "gamma": 0.0} for way in ways[1:]]
    saturating += [
        {"alpha": 7.0 * alpha, "beta": 1.0 / (7.0 * alpha * way**2), "gamma": 0.0, "n": 2.0}
        for way in (scales.stroke / 2.0**halvings for halvings in range(5))
    ]
    slipping = [
        {
            "alpha": strength * scales.stiffness,
            "distributed": 1.0,
            "widest": share * scales.stroke,
            "taper": taper,
        }
        for strength, taper in ((0.02, -1.5), (0.15, -1.5), (0.6, -1.5), (0.15, 0.5))
        for share in (0.3, 0.7)
    ]
    return [*saturating, *slipping]


def likened(other: str, values: Values, scales: Scales) -> Values:
    """Dahl's bristle is a Bouc-Wen force with n = 1, one that slips bit by bit is the same."""
    if other != "friction" or values["coulomb"] <= 0.0:
        return {}
    stiffness = values["stiffness"]
    if values["distributed"] == 1.0:
        slipped = stiffness * all_slipped(values["decades"], values["taper"])
        spread = {name: values[name] for name in SPREAD}
        return {"alpha": stiffness, "widest": values["coulomb"] / slipped, **spread}
    return {"alpha": stiffness, "beta": stiffness / values["coulomb"], "gamma": 0.0}


def rescaled(values: Values, factor: float) -> Values:
    """The decays with which a stronger force is forgotten over the same way: they go with z^n."""
    slower = abs(factor) ** (1.0 - values["n"])
    return {"beta": slower * values["beta"], "gamma": slower * values["gamma"]}


def idle(values: Values) -> Collection[str]:
    """Of a part that has no share."""
    without = {0.0: ("widest", "decades", "taper"), 1.0: ("beta", "gamma")}
    return without.get(values["distributed"], ())


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """Ten times stiffer than the rig is just stuck: no recording tells more."""
    return {"alpha": (0.0, 10.0 * scales.stiffness)}


def memory(values: Values) -> float:
    """The way, m, after which a reversal is forgotten; infinite if it never is."""
    distributed, alpha = values["distributed"], values["alpha"]
    slipped = distributed * 2.0 * values["widest"]
    bending = alpha * (1.0 - distributed)
    if bending == 0.0:
        return slipped
    decay = max(abs(values["beta"] + values["gamma"]), abs(values["beta"] - values["gamma"]))
    if decay == 0.0:
        return math.inf
    bent = float((bending / decay) ** (1.0 / values["n"]) / bending)
    return slipped + (1.0 - distributed) * bent


def says(values: Values, scales: Scales) -> str:
    """Of a turn from where z no longer changes; within a shorter stroke it is less stiff.

    There |z|^n = alpha / (beta + gamma): on the way back z changes by alpha + (beta - gamma) |z|^n
    a metre, and with n = 1 goes to its other end as e^-(beta + gamma) |x|.
    """
    bending = values["alpha"] * (1.0 - values["distributed"])
    forgetting = values["beta"] + values["gamma"]
    slipping, ends = values["alpha"] - bending, bending > 0.0 and forgetting > 0.0
    bent = FORGOTTEN * (bending / forgetting) ** (1.0 / values["n"]) / bending if ends else 0.0
    way = max(bent, 2.0 * values["widest"] if slipping > 0.0 else 0.0)
    text = "the restoring force has hysteresis: "
    if values["alpha"] == 0.0 or (bending > 0.0 and not ends):
        return f"{text}it remembers where the finger has been"
    most = slipping + (2.0 * bending * values["beta"] / forgetting if ends else 0.0)
    stiffer = f"{percent(most / scales.stiffness)} stiffer"
    if way > scales.stroke:
        return f"{text}after a reversal it is up to {stiffer}, and remembers for more than a stroke"
    return (
        f"{text}after each reversal it is {stiffer}, until the finger has moved about "
        f"{quantity(way, 'm')}"
    )


def unusual(values: Values, scales: Scales) -> float:
    """What is soon forgotten is friction, and what gives all back a spring.

    A Bouc-Wen force that is thermodynamically admissible has |gamma| <= beta (Erlicher and Point
    2004); fits of other laws, and published examples, go somewhat beyond.
    """
    short = unusually_short(memory(values), scales)
    if values["distributed"] == 1.0:
        return short
    elastic = abs(values["gamma"]) / max(values["beta"], TINY)
    return short + min(1.0, max(0.0, math.log2(max(elastic / ELASTIC, TINY))))


LINK = Link(
    name="restoring_force_hysteresis",
    stage=Stage.MECHANICS,
    order=40,
    title="hysteresis in the restoring force",
    source=(
        "Bouc 1967, Wen 1976; Noel and Schoukens 2016, doi 10.4121/12967592; Iwan 1966; "
        "Segalman 2005"
    ),
    force=Force(law, coefficients, stiffness, states=1 + SPRINGS, released=released),
    parameters=(
        Parameter("alpha", "N/m", 2e6, 0.0, 1e12, "stiffness after a reversal", 0.0),
        Parameter("beta", RATE_UNIT, 1e5, -1e12, 1e12, "decay of z with travel, both ways"),
        Parameter("gamma", RATE_UNIT, 2e4, -1e12, 1e12, "decay of z by direction"),
        Parameter("n", "1", 1.0, 1.0, 5.0, "sharpness of the bend", fitted=False),
        Parameter(
            "distributed", "1", 0.0, 0.0, 1.0, "share of alpha that slips bit by bit", fitted=False
        ),
        Parameter("widest", "m", 1e-5, 1e-9, 1.0, "distance at which the last bit slips"),
        Parameter("decades", "1", 1.0, 0.0, 3.0, "decades over which the distances are spread"),
        Parameter("taper", "1", -1.0, -5.0, 3.0, "how much stiffer what slips early is"),
        RELEASED,
    ),
    starts=starts,
    likened=likened,
    idle=idle,
    rescaled=rescaled,
    plausible=plausible,
    unusual=unusual,
    says=says,
)
