"""Low-pass dynamics of the drive electronics, first to fourth order.

    c t^2 w'' + t w' + w = u,           t = (1 - third) T,          0 <= c <= 1
    d t'^2 u_s'' + t' u_s' + u_s = w,   t' = third T,               0 <= d <= 1

T is the lag behind a slow ramp. c tells the order: 0 is one lag, t; up to 1/4 it is two lags in a
row that sum to t; at 1/2 the response is maximally flat; at 1 it peaks by 1.15, as that of a fed
back amplifier with little phase to spare. Above 1/4 a step is overshot, by 4.3 % at 1/2 and 16 % at
1, which the hysteresis behind remembers however short T is. A further lag behind takes the share
`third` of T and has a `third_curvature`, d, of its own: filters of third and fourth order and,
nearly, of any higher one.

The link comes last in the drive: what smooths is the output resistance into the stack's
capacitance, behind the stage that clips and limits the current.

Held and straight input are followed exactly. What leaves is taken as straight between the internal
steps, so these are set where the approach to a step bends. Measured against far finer steps, what
that costs is about 1 % of what the lag does to the displacement, 4 % where it peaks and is over
before the rig has moved.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.lag import follow, lag_rows, order
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

PIECES = 12  # of exp(-t/T), chords of equal error 1 / (2 PIECES^2); then the last of it, to zero
BENDS = (*(-2.0 * math.log1p(-i / PIECES) for i in range(1, PIECES)), 7.0, 11.0, 36.0)
TURNS = 3  # of an overshoot that are followed: at c of 1 the third is 0.4 % of a step


def bends(values: Values, sample_period: float) -> set[float]:
    """Ends of the chords that follow the approach after a jump, and the turns of an overshoot."""
    lag, c = (1.0 - values["third"]) * values["lag"], values["curvature"]
    times = {*BENDS}
    if c > 0.25:
        times |= {turn * math.tau * c / math.sqrt(4.0 * c - 1.0) for turn in range(1, TURNS + 1)}
    return {lag * time / sample_period for time in times if lag * time < sample_period}


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State and coefficients are those of `follow`, for a third lag once more after them."""
    lags = state.shape[0] // 3
    steps = coefficients.shape[0] // lags
    for lag in range(lags):
        rows = coefficients[lag * steps : (lag + 1) * steps]
        follow(rows, state[3 * lag : 3 * lag + 3], bus[VOLTAGE], 1.0)


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: the gain at rest is one."""
    third = values["third"] * values["lag"]
    lag = values["lag"] - third
    rows = lag_rows(lag, values["curvature"] * lag**2, timing)
    state = [0.0, 0.0, levels[VOLTAGE]]
    if third > 0.0:
        square = values["third_curvature"] * third**2
        rows = np.vstack([rows, lag_rows(third, square, replace(timing, ramped=True))])
        state *= 2
    return Prepared(rows, np.array(state), ramped=True)


def idle(values: Values) -> Collection[str]:
    """A lag of first or second order stays one: a further is told from these by shape alone."""
    return ("third", "third_curvature") if values["third"] == 0.0 else ()


def starts(scales: Scales) -> Sequence[Values]:
    """From a lag that just shows to a slow amplifier; and of fourth order, four equal lags."""
    lags = [samples * scales.sample_period for samples in (0.5, 1.5, 5.0, 15.0, 50.0)]
    equal = {"curvature": 1 / 4, "third": 1 / 2, "third_curvature": 1 / 4}
    return [*({"lag": lag} for lag in lags), *({"lag": lag, **equal} for lag in lags[1:])]


def behind(values: Values) -> float:
    """The lag is defined as that."""
    return values["lag"]


def says(values: Values, scales: Scales) -> str:
    which = order(values["curvature"])
    if values["third"] > 0.0:
        which = "fourth" if values["third_curvature"] > 0.0 else "third"
    late = quantity(values["lag"], "s")
    return f"the amplifier lags: it follows a ramp of the voltage {late} late ({which} order)"


LINK = Link(
    name="amplifier_lag",
    stage=Stage.DRIVE,
    order=60,
    title="lag of the amplifier",
    source="Fleming and Leang 2014, chapter 14; Butterworth 1930",
    parameters=(
        Parameter("lag", "s", 5e-4, 0.0, 1.0, "delay behind a slow ramp", 0.0),
        Parameter("curvature", "1", 0.1, 0.0, 1.0, "0 first order, 1/4 two equal lags, 1/2 flat"),
        Parameter("third", "1", 0.0, 0.0, 0.5, "share of a further lag; 0 is none of third order"),
        Parameter("third_curvature", "1", 0.0, 0.0, 1.0, "of the further lag; 0 is third order"),
    ),
    prepare=prepare,
    kernel=kernel,
    bends=bends,
    idle=idle,
    starts=starts,
    behind=behind,
    says=says,
)
