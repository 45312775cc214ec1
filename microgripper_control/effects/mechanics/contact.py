"""An object or stop that pushes back beyond a position.

    F = -side max(0, p grip + relaxing stiffening (p - (q_1 + q_2) / 2)),
    grip = min(max(0, 1 + (1 - relaxing) damping depth'), 5/2),

    p = stiffness r (depth / r)^exponent,      depth = max(0, side (x - position)),      r = 1 um
    q_i' = (p - q_i) / T_i,                    T = fastest, slowest

Exponent 1 is a linear spring, 3/2 two curved bodies (Hertz); r is where `stiffness` is force by
depth, so that its unit does not depend on the exponent. The damping of Hunt and Crossley grows with
the depth: the force is continuous at the touch and never pulls. Theirs is 3/2 (1 - restitution)
over the speed of the impact, so the force is never more than 5/2 of that at rest; nor is it here,
however fast a step of the voltage throws the mass.

A soft object relaxes (`relaxing` 1, else 0): pressed fast it pushes back the more, gives way in a
while, and takes that while to come back when it is let go. That is a spring with Maxwell elements
beside it: with one the standard linear solid (Zener 1948); two also pass for the many that real
matter has. `stiffness` is what slow pressing finds. Where it relaxes within few samples the law is
a rough one.
"""

import math
from collections.abc import Collection, Mapping, Sequence

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import number, percent, quantity
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values

REFERENCE = 1e-6  # m, r above
BESIDE = 0.1  # of the stroke: what the nominal model may be wrong about where it ends
MOST_DAMPING = 100.0  # s/m; metals have 0.1 to 0.3, and much lets go whenever the finger turns
MOST_STIFFENING = 10.0  # pressed within a sample; what is stiffer still is damped
SHOWN = 0.05  # of the force: relaxation below that is not spoken of
TOUCHED = 0.55  # of the stroke: what is touched over more is rather a spring of the rig,
ALWAYS = 0.8  # and over so much it is one
HARDEST = 2.5  # times the force at rest: the beginning of an impact from which nothing springs back


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    side = c[4]
    depth = side * (x1 - c[0])
    force = 0.0
    if depth > 0.0:
        shape = 1.0 if c[2] == 1.0 else (depth / REFERENCE) ** (c[2] - 1.0)
        force = c[1] * depth * shape
    push = force * min(max(0.0, 1.0 + c[3] * side * v), HARDEST)
    if c[5] == 0.0:
        return float(-side * push)
    old, held = before[0], 0.0  # p, as in `after`, then q_1 and q_2
    for i in range(1, 3):
        time = c[5 + i]
        kept = math.exp(-step / time)
        followed = 1.0 - (1.0 - kept) * time / step if step > 0.0 else 0.0  # of a straight course
        slow = old + followed * (force - old) + kept * (before[i] - old)
        held += 0.5 * (force - slow)
        after[i] = slow
    after[0] = force
    return float(-side * max(0.0, push + c[5] * held))


def coefficients(values: Values) -> Sequence[float]:
    relaxing, side = values["relaxing"], 1.0 if values["side"] >= 0.0 else -1.0
    damping, stiffening = (1.0 - relaxing) * values["damping"], relaxing * values["stiffening"]
    shape = (values["position"], values["stiffness"], values["exponent"], damping, side)
    return (*shape, stiffening, values["fastest"], values["slowest"])


def stiffness(values: Values) -> float:
    fast = 1.0 + values["relaxing"] * values["stiffening"]
    return values["exponent"] * values["stiffness"] * fast


def starts(scales: Scales) -> Sequence[Values]:
    """An object met in the upper or lower part of the stroke, as stiff as a tenth of the rig."""
    return [
        {
            "position": scales.position[0] + share * scales.stroke,
            "stiffness": 0.1 * scales.stiffness,
            "side": side,
            **kind,
        }
        for side, shares in ((1.0, (0.2, 0.4, 0.6, 0.75, 0.9)), (-1.0, (0.1, 0.25, 0.4, 0.6)))
        for share in shares
        for kind in ({"exponent": 1.0}, {"exponent": 1.5}, {"relaxing": 1.0})
    ]


def idle(values: Values) -> Collection[str]:
    """Of what an object loses its energy by, one or the other."""
    return ("damping",) if values["relaxing"] else ("stiffening", "fastest", "slowest")


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """What is touched all the time is a spring of the rig; what is never touched is not there.

    A stop that is a hundred times stiffer than the rig is just hard: no recording tells more. What
    relaxes within a sample is damping.
    """
    low, high = scales.position
    beside = BESIDE * scales.stroke
    return {
        "position": (low - beside, high + beside),
        "stiffness": (0.0, 100.0 * scales.stiffness),
        "damping": (0.0, MOST_DAMPING),
        "stiffening": (0.0, MOST_STIFFENING),
        "fastest": (scales.sample_period, scales.duration),
        "slowest": (scales.sample_period, scales.duration),
    }


def unusual(values: Values, scales: Scales) -> float:
    """An object is met on the way; what pushes back over most of the stroke is a spring."""
    if scales.stroke <= 0.0:
        return 0.0
    way = values["position"] - scales.position[0]
    touched = (scales.stroke - way if values["side"] >= 0.0 else way) / scales.stroke
    return min(1.0, max(0.0, (touched - TOUCHED) / (ALWAYS - TOUCHED)))


def says(values: Values, scales: Scales) -> str:
    way = "beyond" if values["side"] >= 0.0 else "below"
    where, push = quantity(values["position"], "m", 3), number(1e-6 * values["stiffness"])
    depth = "for each µm" if values["exponent"] == 1.0 else "at 1 µm of depth"
    text = f"the finger meets something: {way} x = {where} it is pushed back, by {push} N {depth}"
    if not values["relaxing"] or values["stiffening"] < SHOWN:
        return text
    more, while_ = percent(values["stiffening"]), quantity(values["slowest"], "s", 1)
    return f"{text}, and {more} more if pressed faster than some {while_}"


LINK = Link(
    name="contact",
    stage=Stage.MECHANICS,
    order=20,
    title="contact with an object or stop",
    source="Hertz 1881; Hunt and Crossley 1975; Zener 1948",
    force=Force(law, coefficients, stiffness, states=3, fading=True, brakes=True),
    parameters=(
        Parameter("position", "m", 1.5e-5, -1.0, 1.0, "where the finger touches"),
        Parameter("stiffness", "N/m", 2e6, 0.0, 1e12, "force per depth, 1 µm deep", 0.0),
        Parameter("exponent", "1", 1.0, 1.0, 3.0, "1 linear, 1.5 Hertz", fitted=False),
        Parameter("damping", "s/m", 0.0, 0.0, 1e3, "share of the force that is added per speed"),
        Parameter(
            "relaxing",
            "1",
            0.0,
            0.0,
            1.0,
            "1 if it gives way with time, 0 if not",
            0.0,
            fitted=False,
        ),
        Parameter("stiffening", "1", 0.5, 0.0, 1e3, "how much stiffer it is when pressed fast"),
        Parameter(
            "fastest", "s", 0.05, 1e-4, 1e3, "time in which the faster half of that is forgotten"
        ),
        Parameter(
            "slowest", "s", 0.5, 1e-4, 1e3, "time in which the slower half of that is forgotten"
        ),
        Parameter("side", "1", 1.0, -1.0, 1.0, "1 beyond, -1 below the position", fitted=False),
    ),
    starts=starts,
    idle=idle,
    plausible=plausible,
    unusual=unusual,
    says=says,
)
