"""Bounded rate of the drive voltage: the amplifier's current limit into the stack's capacitance.

    q' = (q(u) - q) / (knee time),           -1 / fall <= q' <= 1 / rise,     u_s = u(q)
    rise = time (1 + asymmetry),             fall = time (1 - asymmetry)

A time per volt is C / i_max: the effect vanishes at zero. A ferroelectric's capacitance grows with
the voltage; the limit is one of charge, q(u) = (e^(growth u) - 1) / growth, in V. An amplifier that
is less than about `knee` behind regulates and gives less than all its current; at zero it follows
as fast as it may. Recordings that are fast
one way only say nothing about the other; the same limit is then assumed both ways. The link stands
behind the saturation, so that no charge is owed for a command beyond the range, and before the lag
of the output.

Behind held input, and behind straight input at growth 0, the voltage at the end of a step is exact,
changes of pace inside it included; else the charge is taken as straight within a step. What leaves
is taken as straight in between; boundaries ever farther from a jump keep the corner sharp at any
slew rate, down to where the effect vanishes.
"""

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.exponential import before_growth, grown
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import number
from microgripper_control.core.signals import VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

JUMPS = (0.5, 256.0)  # V: of what sizes the end of the ramp is drawn well at any slew rate
GROWTH = 2.0**0.5  # from boundary to boundary after a jump,
PHASES = 4  # of a step at most: it is limited one way, regulates, is limited the other way
PIECES = 12  # until they are as far apart as this part of a sample period
FREE = 20.0  # times the fastest change on record: such a limit leaves no trace
SHARES = (6.0, 3.0, 1.7, 0.95, 0.8, 0.65, 0.5, 0.4, 0.3, 0.22, 0.16, 0.12, 0.09, 0.05, 0.03)


def _both_ways(values: Values) -> tuple[float, float]:
    """Shortest times per volt, s/V, upwards and downwards; 0 where nothing limits."""
    time, asymmetry = values["time"], values["asymmetry"]
    return time * (1.0 + asymmetry), time * (1.0 - asymmetry)


def bends(values: Values, sample_period: float) -> set[float]:
    """Where jumps of various sizes have been worked off."""
    found = set()
    for way in _both_ways(values):
        small, large = (volts * way / sample_period for volts in JUMPS)
        while 0.0 < small < min(1.0, large):
            found.add(small)
            small += min((GROWTH - 1.0) * small, 1.0 / PIECES)
    return found


@compiled
def late_after(late: float, run: float, up: float, down: float, lag: float) -> float:
    """By how much the output is behind at the end of a step; `late` at its begin, all in V.

    The input changes by `run`, the output by `up` or `down` at most. Within what is regulated, with
    a time constant of `lag` steps, it follows exponentially; beyond, it goes at full rate.
    """
    top, bottom = (up * lag, -down * lag) if lag > 0.0 else (0.0, 0.0)
    left = 1.0
    for _ in range(PHASES):
        rising = late > top or (late == top and run > up)
        falling = late < bottom or (late == bottom and run < -down)
        if not (rising or falling):
            if lag == 0.0:
                return late  # 0, or no number
            goal = run * lag
            end = goal + (late - goal) * math.exp(-left / lag)
            if bottom <= goal <= top or not (end < bottom or end > top):  # also if it is NaN
                return end
            bound = top if goal > top else bottom
            left -= lag * math.log((late - goal) / (bound - goal))
        else:
            bound, pace = (top, up) if rising else (bottom, -down)
            until = (bound - late) / (run - pace) if run != pace else math.inf
            if late == bound or not 0.0 <= until < left:
                return late + (run - pace) * left
            left -= until
        late = bound
    return late


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: charge of output and input so far, over the capacitance at 0 V, in V.

    Rows: charge up and down in a step, whether the input is held, the growth, and the time constant
    of the regulation in steps.
    """
    y, old = state[0], state[1]
    steps, row = coefficients.shape[0], 0
    for j in range(bus.shape[1]):
        up, down, held, growth, lag = coefficients[row]
        new = grown(bus[VOLTAGE, j], growth)
        begin = new if held == 1.0 else old
        y = new - late_after(begin - y, new - begin, up, down, lag)
        old = new
        bus[VOLTAGE, j] = before_growth(y, growth)
        row = row + 1 if row + 1 < steps else 0
    state[0], state[1] = y, old


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: at rest the output has arrived."""
    growth = values["growth"]
    rows = [
        [step / way if way > 0.0 else math.inf for way in _both_ways(values)]
        + [float(not timing.ramped), growth, values["knee"] * values["time"] / step]
        for step in timing.steps
    ]
    state = np.full(2, grown(float(levels[VOLTAGE]), growth))
    return Prepared(np.array(rows), state, ramped=True)


def starts(scales: Scales) -> Sequence[Values]:
    """Limits about the fastest change on record, one way or both.

    A held voltage changes at once, and a limit above what the samples show still rounds its jumps.
    """
    times = [1.0 / (share * scales.rate) for share in SHARES]
    both_ways = [{"time": time} for time in times]
    one_way = [{"time": 0.5 * t, "asymmetry": way} for way in (-1.0, 1.0) for t in times]
    return [*both_ways, *one_way]


def says(values: Values, scales: Scales) -> str:
    """Of both ways only that which is limited, if the other is free to do all that is asked."""
    ways = [pair for pair in zip(("rises", "falls"), _both_ways(values), strict=True) if pair[1]]
    tight = [(way, t) for way, t in ways if t * FREE * scales.rate > 1.0] or ways
    limits = " and ".join(f"{way} by {number(1.0 / t)} V/s at most" for way, t in tight)
    growth = values["growth"]
    above = "" if growth == 0.0 else f" at 0 V, and {'less' if growth > 0.0 else 'more'} above"
    return f"the amplifier is short of current: the voltage {limits}{above}"


LINK = Link(
    name="slew_limit",
    stage=Stage.DRIVE,
    order=40,
    title="slew limit of the amplifier",
    source="i = C du/dt at the current limit; Fleming and Leang 2014, chapter 14",
    parameters=(
        Parameter("time", "s/V", 4e-5, 0.0, 1.0, "shortest time per volt, mean of both ways", 0.0),
        Parameter("asymmetry", "1", 0.0, -1.0, 1.0, "1: only rises are limited, -1: only falls"),
        Parameter("growth", "1/V", 0.0, -0.02, 0.02, "of the capacitance with the voltage"),
        Parameter("knee", "V", 0.0, 0.0, 2.0, "behind the command: from here on at full current"),
    ),
    prepare=prepare,
    kernel=kernel,
    bends=bends,
    starts=starts,
    says=says,
)
