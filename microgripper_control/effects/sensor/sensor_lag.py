"""The sensor's lag: averaging over a time, then a filter of first or second order.

    m(t) = (1 / averaging) integral of x from t - averaging to t,
    c t^2 y'' + t y' + y = m,   t = time_constant,   0 <= c <= 1

Either may be absent. c, the curvature, tells the order as it does for the amplifier's lag: 0 is one
lag; up to 1/4 it is two lags in a row that sum to t; at 1/2 the response is maximally flat, as
filters before a converter often are; at 1 it peaks by 1.15.

The reading may be held between conversions on a clock of the sensor's own (`conversion_clock`).

The average is that of the straight lines between the internal steps, exactly; the filter takes m as
straight in the same way.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.lag import advance_lag, follow, lag_rows, order
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values
from microgripper_control.effects.conversion_clock import CLOCK, says_clock

HEAD = 6  # of the state, before the rings
CORNERS = 16  # in a sample period, of the course that a clock reads
SHOWN = 0.05  # of the longer time: a shorter one is not spoken of


def breaks(values: Values, sample_period: float) -> set[float]:
    """Where the course between samples bends, if a clock reads it at any instant.

    Most after a jump. Where a jump leaves the window there is another corner, but divisions that
    move with what is fitted would disturb its derivatives.
    """
    if values["clock"] == 0.0 or not (values["averaging"] or values["time_constant"]):
        return set()
    return {(corner / CORNERS) ** 2 for corner in range(CORNERS)}


@compiled
def _back(at: int, places: int, size: int) -> int:
    """The place so many before another in a ring; a remainder would take most of the time here."""
    return at - places if at >= places else at - places + size


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: y - m, y', m, the part of m from whole steps, their count, the newest place in rings.

    Then the two rings: x at the ends of past steps, and what each step as a whole gives to m. The
    coefficients are the filter's, then what `_window` gives, then half of what a step gives to m.
    """
    if coefficients[0, 9] == 0.0:  # no average: m is x
        follow(coefficients, state, bus[POSITION], 1.0)
        return
    away, v, m = state[0], state[1], state[2]
    area, inside, at = state[3], int(state[4]), int(state[5])
    steps = coefficients.shape[0]
    size = (state.shape[0] - HEAD) // 2
    x, areas = state[HEAD : HEAD + size], state[HEAD + size :]
    row = 0
    for j in range(bus.shape[1]):
        c = coefficients[row]
        row = row + 1 if row + 1 < steps else 0
        before, at = at, at + 1 if at + 1 < size else 0
        x[at] = bus[POSITION, j]
        areas[at] = c[9] * (x[before] + x[at])
        area += areas[at]
        inside += 1
        while inside > c[6]:
            inside -= 1
            area -= areas[_back(at, inside, size)]
        if inside == 0:
            area = 0.0  # and rounding starts afresh
        old = m
        oldest = _back(at, inside, size)
        m = area + c[7] * x[oldest] + c[8] * x[_back(oldest, 1, size)]
        away, v = advance_lag(c, away, v, m - old)
        bus[POSITION, j] = m + away
    state[0], state[1], state[2], state[3], state[4], state[5] = away, v, m, area, inside, at


def _window(averaging: float, timing: Timing, last: int) -> tuple[int, float, float]:
    """Reach of a window that ends with step `last` of a sample period.

    How many whole steps it covers and, of the step before these, what share of the window's area
    each unit of x at that step's end and at its beginning gives.
    """
    if averaging == 0.0:
        return 0, 1.0, 0.0
    periods = int(averaging / timing.sample_period)
    left = averaging - periods * timing.sample_period
    count, step = periods * len(timing.steps), last
    while left > timing.steps[step]:
        left -= timing.steps[step]
        count, step = count + 1, step - 1
    entered = left / timing.steps[step]
    return count, left * (1.0 - entered / 2.0) / averaging, left * entered / 2.0 / averaging


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: the gain at rest is one."""
    averaging, lag, level = values["averaging"], values["time_constant"], levels[POSITION]
    rows = []
    for index, step in enumerate(timing.steps):
        half = step / (2.0 * averaging) if averaging > 0.0 else 0.0
        rows.append((*_window(averaging, timing, index), half))
    size = max(row[0] for row in rows) + 2
    # As if x had rested at its level for ever: the rings end with the last step of a period.
    halves = np.array([row[3] for row in rows])
    areas = 2.0 * level * np.resize(halves[::-1], size)[::-1]
    inside = rows[-1][0]
    head = (0.0, 0.0, level, areas[size - inside :].sum(), inside, size - 1)
    state = np.concatenate([head, np.full(size, level), areas])
    behind = lag_rows(lag, values["curvature"] * lag**2, replace(timing, ramped=True))
    return Prepared(np.hstack([behind, np.array(rows)]), state, timing.ramped)


def idle(values: Values) -> Collection[str]:
    """An average, or a filter of first order, stays one: the second is told from it by shape."""
    return ("curvature",) if values["curvature"] == 0.0 else ()


def starts(scales: Scales) -> Sequence[Values]:
    """Averaging alone and a filter alone, of either order, over few and over many samples."""
    times = [samples * scales.sample_period for samples in (0.7, 2.0, 6.0, 20.0, 60.0)]
    found = [
        values
        for time in times
        for values in (
            {"averaging": time, "time_constant": 0.0},
            {"averaging": 0.0, "time_constant": time},
            {"averaging": 0.0, "time_constant": time, "curvature": 0.5},
        )
    ]
    if scales.clock > 0.0:  # nothing but the last exposure is read, or the mean of some
        own = {"time_constant": 0.0, "clock": scales.clock}
        found += [{"averaging": n * scales.clock, **own} for n in (0, 1, 2, 4, 8)]
    return found


def behind(values: Values) -> float:
    """Half of what is averaged over, the filter's lag, and half a cycle of the sensor's clock."""
    return 0.5 * values["averaging"] + values["time_constant"] + 0.5 * values["clock"]


def says(values: Values, scales: Scales) -> str:
    filtered = f" ({order(values['curvature'])} order)"
    parts = (
        ("averages over", values["averaging"], ""),
        ("has a time constant of", values["time_constant"], filtered),
    )
    longest = max(time for _, time, _ in parts)
    shown = [
        f"{how} {quantity(time, 's')}{more}" for how, time, more in parts if time > SHOWN * longest
    ]
    clauses = [f"it {' and '.join(shown)}"] if shown else []
    return f"the sensor lags: {', and '.join([*clauses, *says_clock(values)])}"


LINK = Link(
    name="sensor_lag",
    stage=Stage.SENSOR,
    order=10,
    title="lag of the sensor",
    source="definitions of a moving average and of low-passes; Butterworth 1930",
    parameters=(
        Parameter("averaging", "s", 1e-3, 0.0, 1.0, "time over which a reading is averaged", 0.0),
        Parameter(
            "time_constant", "s", 1e-3, 0.0, 1.0, "lag of the filter behind the averaging", 0.0
        ),
        Parameter("curvature", "1", 0.0, 0.0, 1.0, "0 first order, 1/4 two equal lags, 1/2 flat"),
        CLOCK,
    ),
    prepare=prepare,
    kernel=kernel,
    breaks=breaks,
    follows=True,
    clocked=True,
    idle=idle,
    behind=behind,
    starts=starts,
    says=says,
)
