"""Hysteresis that widens with the rate of the voltage, about as its logarithm.

    w_r = w - f h - e - late (g - h),    f = strength R,    R = (q^power - 1) / (power ln 10),
    q = (reference + r) / (reference + pivot),    r' = (|u'| - r) / memory,
    e' = -fed f' h - (beta |u'| + gamma u' sgn h) e
         - fed R (fading |u'| + turning u' sgn (h + e)) (h + e),
    g' = (h - g) / memory

h is the paper's, which is what the loop is made of; the rate r forgets the past within `memory`.
With fed = 0 the loop is scaled at once. With fed = 1 the material remembers at what rate it was
driven: where beta and gamma are those of h, f h + e is a second Bouc-Wen variable with n = 1 that
is fed f times as much as h. `fading` and `turning` let beta and gamma depend on the rate as well.

R is log10 q at power 0: far above `reference` each decade of the rate adds the share `strength`.
With a power above zero the fast decades add more than the slow ones (Box and Cox's family). At the
rate `pivot` the loop is the paper's, which has been like that all the time before a run begins. A
jump of a held voltage counts as its height, spread over `memory`, and finds r there already.

With `slope` above zero a loop of its own widens: of plays up to `widest`, whose thresholds grow by
the share `growth` a decade (`widening_plays`); a fit then leaves the rest of the law as it is.

`late` is the share of h that has not come yet when the voltage changes within `memory`: domains
that switch with a delay. A share below zero overshoots.
"""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.exponential import grown
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import number, percent, quantity
from microgripper_control.core.signals import FREE, HYSTERESIS, PLACES, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values
from microgripper_control.effects.widening_plays import PLAYS, at_rest, move_plays

LONGEST = 0.02  # of the longest recording


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: the voltage so far, r, h, f, e, g, and the plays.

    A row: decay of r, what |change| of the voltage adds to r at once and on the way, 1 / reference,
    ln (1 + pivot / reference), strength, fading and turning over ln 10, fed, beta, gamma, power,
    late, and of the plays slope over their number, first threshold, growth over ln 10.
    """
    steps, row, plays = coefficients.shape[0], 0, state[6:]
    u, rate, h, f, e, g = state[0], state[1], state[2], state[3], state[4], state[5]
    c = coefficients[0]
    last = grown(math.log1p(rate * c[3]) - c[4], c[11])
    for j in range(bus.shape[1]):
        c = coefficients[row]
        du, new = bus[VOLTAGE, j] - u, bus[HYSTERESIS, j]
        u = bus[VOLTAGE, j]
        way, kept, level = abs(du), 1.0, last
        moves = c[1] == 0.0 or way > 0.0  # between two samples a held voltage mostly does not
        if moves:
            turn = du if h + new >= 0.0 else -du
            kept = math.exp(-(c[9] * way + c[10] * turn))
        if c[1] > 0.0:  # held: first the rate jumps, then the voltage, and then the rate decays
            if moves:
                rate += c[1] * way
                level = grown(math.log1p(rate * c[3]) - c[4], c[11])
            e = kept * (e - c[8] * (c[5] * level - f) * h)
            f, over, middle = c[5] * level, new, new
            rate = c[0] * rate + c[2] * way
            last = grown(math.log1p(rate * c[3]) - c[4], c[11])
        else:
            e *= kept
            over = 0.5 * (h + new)
            middle = over * math.sqrt(kept)
            rate = c[0] * rate + c[2] * way
            last = level = grown(math.log1p(rate * c[3]) - c[4], c[11])
        later = c[5] * last
        e -= c[8] * (later - f) * middle
        if moves:
            whole = over + e
            turn = du if whole >= 0.0 else -du
            e += whole * math.expm1(-level * (c[6] * way + c[7] * turn))
        g = over + (g - over) * c[0]
        h, f = new, later
        bus[FREE, j] -= f * h + e + c[12] * (g - h)
        if c[13] != 0.0:
            if moves:
                move_plays(plays, u, c[14], c[15] * level)
            bus[FREE, j] -= c[13] * move_plays(plays, u, c[14], c[15] * last)
        row = row + 1 if row + 1 < steps else 0
    state[0], state[1], state[2], state[3], state[4], state[5] = u, rate, h, f, e, g


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """At rest the rate is zero: what is below the pivot then widens h that is not fed less."""
    memory, steps = values["memory"], np.array(timing.steps)
    about = math.log1p(values["pivot"] / values["reference"])
    resting = grown(-about, values["power"])
    by_decade = np.array([values[name] for name in ("strength", "fading", "turning")])
    by_decade *= np.array([1.0, values["fed"], values["fed"]]) / math.log(10.0)
    rows = np.zeros((len(steps), 16))
    rows[:, 0] = np.exp(-steps / memory)
    if timing.ramped:
        rows[:, 2] = -np.expm1(-steps / memory) / steps
    else:
        rows[:, 1] = 1.0 / memory
    rows[:, 3:] = (
        *(1.0 / values["reference"], about, *by_decade),
        *(values["fed"], values["beta"], values["gamma"], values["power"], values["late"]),
        *(values["slope"] / PLAYS, values["widest"] / PLAYS, values["growth"] / math.log(10.0)),
    )
    h, f = levels[HYSTERESIS], by_decade[0] * resting
    own = [levels[VOLTAGE], 0.0, h, f, -values["fed"] * f * h, h]
    levels[PLACES + FREE] -= (1.0 - values["fed"]) * f * levels[PLACES + HYSTERESIS]
    state = np.append(own, at_rest(levels[VOLTAGE]))
    return Prepared(rows, state, timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Memories from a few samples to the longest plausible one; h fed more, scaled, or late; plays.

    The pivot lies between slow and fast: the refitted plant is right at rates that it has met.
    """
    shortest = 3.0 * scales.sample_period
    pivot = {"pivot": math.sqrt(scales.rate * scales.swing / scales.duration)}
    fed = {"fed": 1.0, "beta": 2.4 / scales.swing, "gamma": -3.6 / scales.swing}  # as the paper's
    ways = (
        fed | {"reference": 10.0},
        fed | {"reference": 300.0},
        fed | {"reference": 300.0, "power": 0.4},
        {"fed": 0.0},
        fed | {"reference": 300.0, "strength": 0.0, "late": 0.1},
    )
    of_h = [
        {"strength": 0.05, "memory": memory} | pivot | way
        for way in ways
        for memory in np.geomspace(shortest, longest(scales), 5)
    ]
    slope = 0.1 * scales.stroke / scales.swing
    of_plays = [
        {"strength": 0.0, "memory": memory, "slope": slope, "reference": reference}
        | {"widest": share * scales.swing}
        for memory in np.geomspace(shortest, longest(scales), 3)
        for share in (0.05, 0.12, 0.3)
        for reference in (10.0, 100.0)
    ]
    return [*of_h, *of_plays]


def longest(scales: Scales) -> float:
    """The longest memory, s, of what can be called a rate: what lasts longer drifts or creeps."""
    return max(LONGEST * scales.duration, 20.0 * scales.sample_period, 1e-3)


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """What is averaged over long follows any drift.

    What makes e grow by more than a power of e^10 over the swing would run away.
    """
    most = 10.0 / scales.swing
    return {
        "memory": (1e-4, longest(scales)),
        "fading": (-most, most),
        "turning": (-most, most),
        "widest": (0.01 * scales.swing, 0.6 * scales.swing),
    }


def idle(values: Values) -> Collection[str]:
    """What is not fed does not decay; `late` and `power` are left at zero if they start there.

    So is `slope`, and where plays widen, nothing is done to h.
    """
    if values["slope"] != 0.0:
        return "strength", "beta", "gamma", "fading", "turning", "late", "power"
    decay = () if values["fed"] else ("beta", "gamma", "fading", "turning")
    off = (name for name in ("late", "power") if values[name] == 0.0)
    return *decay, *off, "slope", "widest", "growth"


def says(values: Values, scales: Scales) -> str:
    if values["slope"] != 0.0:
        way = "widen" if values["growth"] >= 0.0 else "narrow"
        return (
            f"the hysteresis depends on the rate: plays of up to {number(values['widest'])} V, a "
            f"part of the loop, {way} by {percent(abs(values['growth']))} per decade of rate"
        )
    strength, late = values["strength"], values["late"]
    if abs(late) > abs(strength):
        way, share = "narrows" if late >= 0.0 else "widens", percent(abs(late))
        change = f"{share} where the voltage changes within {quantity(values['memory'], 's', 1)}"
    else:
        way, share = "widens" if strength >= 0.0 else "narrows", percent(abs(strength))
        change = f"{share} per decade of rate"
    return f"the hysteresis depends on the rate: the loop {way} by {change}"


LINK = Link(
    name="rate_dependent_hysteresis",
    stage=Stage.MATERIAL,
    order=20,
    title="hysteresis that widens with the rate",
    source="Ang, Khosla, Riviere 2007; Al Janaideh, Rakheja, Su 2011 (weights that follow rate)",
    parameters=(
        Parameter("strength", "1", 0.1, -1.0, 5.0, "share of h added in a decade of rate", 0.0),
        Parameter("memory", "s", 0.02, 1e-4, 100.0, "time over which the rate is averaged"),
        Parameter("beta", "1/V", 0.0152, -1.0, 100.0, "decay of e with travel, both ways"),
        Parameter("gamma", "1/V", -0.0227, -100.0, 100.0, "decay of e by direction"),
        Parameter("fading", "1/V", 0.0, -10.0, 10.0, "what a decade of rate adds to beta", 0.0),
        Parameter("turning", "1/V", 0.0, -10.0, 10.0, "what a decade of rate adds to gamma", 0.0),
        Parameter("late", "1", 0.0, -1.0, 5.0, "share of h that comes late by `memory`", 0.0),
        Parameter(
            "power",
            "1",
            0.0,
            -1.0,
            1.0,
            "0: every decade of rate counts alike; above 0: fast ones more",
        ),
        Parameter("slope", "m/V", 0.0, 0.0, 1e-3, "slope of the loop that plays make", 0.0),
        Parameter("widest", "V", 20.0, 1e-3, 1e4, "threshold of the widest play"),
        Parameter("growth", "1", 0.3, -1.0, 20.0, "growth of the thresholds in a decade of rate"),
        Parameter("fed", "1", 1.0, 0.0, 1.0, "1: h is fed more; 0: it is scaled", fitted=False),
        Parameter(
            "reference", "V/s", 10.0, 1e-6, 1e9, "rate from which on the loop widens", fitted=False
        ),
        Parameter("pivot", "V/s", 0.0, 0.0, 1e9, "rate of the paper's loop", fitted=False),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    plausible=plausible,
    idle=idle,
    says=says,
)
