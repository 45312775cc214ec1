"""An object or stop that pushes back beyond a position, and may stick.

    F = -side (max(0, p grip + relaxing stiffening (p - (q_1 + q_2) / 2)) - adhesion s),
    grip = min(max(0, 1 + (1 - relaxing) damping depth'), 5/2),

    p = stiffness r (depth / r)^exponent,      depth = max(0, side (x - position)),      r = 1 um
    q_i' = (p - q_i) / T_i,                    T = slowest / 10^decades, slowest

Exponent 1 is a linear spring, 3/2 two curved bodies (Hertz); r is where `stiffness` is force by
depth, so that its unit does not depend on the exponent. The damping of Hunt and Crossley grows with
the depth: the force is continuous at the touch and never pulls. Theirs is 3/2 (1 - restitution)
over the speed of the impact, so the force is never more than 5/2 of that at rest; nor is it here,
however fast a step of the voltage throws the mass.

What sticks snaps in and lets go later: a neck of glue, of moisture or of molecules pulls with
`adhesion` N on top of the rest (Derjaguin, Muller, Toporov 1975), from the touch on until the
finger has gone back by `reach`. s is the neck: it grows with the depth, is whole at a tenth of
`reach`, and keeps of that, on the way back, the least that 1 - (-depth / reach)^4 has been. The
mass is pulled by the neck of the step before, so each step has one solution although the whole has
two: it snaps in and tears off within few steps.

A soft object relaxes (`relaxing` 1, else 0): pressed fast it pushes back the more, gives way in a
while, and takes that while to come back when it is let go. That is a spring with Maxwell elements
beside it: with one the standard linear solid (Zener 1948); two also pass for the many that real
matter has. `stiffness` is what slow pressing finds. Where it relaxes within few samples the law is
a rough one.
"""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import number, percent, quantity
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values

REFERENCE = 1e-6  # m, r above
BESIDE = 0.1  # of the stroke: what the nominal model may be wrong about where it ends
MOST_DAMPING = 100.0  # s/m; metals have 0.1 to 0.3, and much lets go whenever the finger turns
MOST_STIFFENING = 10.0  # pressed within a sample; what is stiffer still is damped
GROWN = 0.1  # of the reach: the depth at which a neck is whole
MOST_ADHESION = 0.1  # of the force over the stroke
SHOWN = 0.05  # of the force: relaxation below that is not spoken of
PLACES, REACH, WEAK = 8, 0.02, 2e-3  # of the stroke, and of the force over it: guesses
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
    pull = 0.0
    if c[8] > 0.0:
        neck = before[3]
        pull = c[8] * neck
        grown = min(1.0, max(0.0, depth) / (GROWN * c[9]))
        torn = min(1.0, max(0.0, -depth) / c[9])
        after[3] = min(max(neck, grown), 1.0 - torn**4)
    if c[5] == 0.0:
        return float(side * (pull - push))
    old, held = before[0], 0.0  # p, as in `after`, then q_1 and q_2
    for i in range(1, 3):
        time = c[5 + i]
        kept = math.exp(-step / time)
        followed = 1.0 - (1.0 - kept) * time / step if step > 0.0 else 0.0  # of a straight course
        slow = old + followed * (force - old) + kept * (before[i] - old)
        held += 0.5 * (force - slow)
        after[i] = slow
    after[0] = force
    return float(side * (pull - max(0.0, push + c[5] * held)))


def coefficients(values: Values) -> Sequence[float]:
    relaxing, side = values["relaxing"], 1.0 if values["side"] >= 0.0 else -1.0
    damping, stiffening = (1.0 - relaxing) * values["damping"], relaxing * values["stiffening"]
    shape = (values["position"], values["stiffness"], values["exponent"], damping, side)
    soft = (stiffening, values["slowest"] / 10.0 ** values["decades"], values["slowest"])
    return (*shape, *soft, values["adhesion"], values["reach"])


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


def more(values: Values, scales: Scales) -> Sequence[Values]:
    """It sticks: where it was thought to be met, or elsewhere, for what pulls hides where that is.

    And how it pushes back, so it may be of either shape.
    """
    if values["adhesion"] > 0.0:
        return []
    low, high = scales.position
    met = [values["position"], *np.linspace(low, high, PLACES + 2)[1:-1].tolist()]
    neck = {
        "adhesion": WEAK * scales.stiffness * scales.stroke,
        "reach": REACH * scales.stroke,
        "relaxing": 0.0,
    }
    return [
        {**neck, "position": position, "exponent": exponent}
        for position in met
        for exponent in (1.0, 1.5)
    ]


def idle(values: Values) -> Collection[str]:
    """Of what an object loses its energy by, one or the other; what does not stick does not."""
    loose = () if values["adhesion"] else ("adhesion", "reach")
    return (*loose, *(("damping",) if values["relaxing"] else ("stiffening", "decades", "slowest")))


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
        "adhesion": (0.0, MOST_ADHESION * scales.stiffness * scales.stroke),
        "reach": (1e-3 * scales.stroke, scales.stroke),
        "damping": (0.0, MOST_DAMPING),
        "stiffening": (0.0, MOST_STIFFENING),
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
    if values["adhesion"]:
        pull = number(values["adhesion"])
        text += f"; it sticks with {pull} N until {quantity(values['reach'], 'm', 2)} before that"
    if not values["relaxing"] or values["stiffening"] < SHOWN:
        return text
    more, while_ = percent(values["stiffening"]), quantity(values["slowest"], "s", 1)
    return f"{text}, and {more} more if pressed faster than some {while_}"


LINK = Link(
    name="contact",
    stage=Stage.MECHANICS,
    order=20,
    title="contact with an object or stop",
    source="Hertz 1881; Hunt, Crossley 1975; Zener 1948; Derjaguin, Muller, Toporov 1975",
    force=Force(law, coefficients, stiffness, states=4, fading=True, brakes=True),
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
            "slowest", "s", 0.5, 1e-4, 1e3, "time in which the slower half of that is forgotten"
        ),
        Parameter("decades", "1", 1.0, 0.0, 3.0, "so much faster is the faster half"),
        Parameter("adhesion", "N", 0.0, 0.0, 1e6, "how strongly it sticks once touched", 0.0),
        Parameter("reach", "m", 2e-7, 1e-12, 1.0, "how far off the touch it lets go"),
        Parameter("side", "1", 1.0, -1.0, 1.0, "1 beyond, -1 below the position", fitted=False),
    ),
    starts=starts,
    more=more,
    idle=idle,
    plausible=plausible,
    unusual=unusual,
    says=says,
)
