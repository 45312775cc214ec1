"""The sensor's lag: averaging over a time, then a filter of first order.

    m(t) = (1 / averaging) integral of x from t - averaging to t,        time_constant y' + y = m

Either may be absent. The average is that of the straight lines between the internal steps, exactly;
the filter takes m as straight in the same way.
"""

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

HEAD = 5  # of the state, before the rings
SHOWN = 0.05  # of the longer time: a shorter one is not spoken of


@compiled
def _back(at: int, places: int, size: int) -> int:
    """The place so many before another in a ring; a remainder would take most of the time here."""
    return at - places if at >= places else at - places + size


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: y, m, the part of m from whole steps, their count, the newest place in two rings.

    Then the rings: x at the ends of past steps, and what each step as a whole gives to m.
    """
    y, m, area, inside, at = state[0], state[1], state[2], int(state[3]), int(state[4])
    steps = coefficients.shape[0]
    size = (state.shape[0] - HEAD) // 2
    x, areas = state[HEAD : HEAD + size], state[HEAD + size :]
    row = 0
    for j in range(bus.shape[1]):
        c = coefficients[row]
        row = row + 1 if row + 1 < steps else 0
        before, at = at, at + 1 if at + 1 < size else 0
        x[at] = bus[POSITION, j]
        areas[at] = c[3] * (x[before] + x[at])
        area += areas[at]
        inside += 1
        while inside > c[0]:
            inside -= 1
            area -= areas[_back(at, inside, size)]
        if inside == 0:
            area = 0.0  # and rounding starts afresh
        old = m
        oldest = _back(at, inside, size)
        m = area + c[1] * x[oldest] + c[2] * x[_back(oldest, 1, size)]
        behind = c[5] * (m - old)
        y = m - behind + c[4] * (y - old + behind)
        bus[POSITION, j] = y
    state[0], state[1], state[2], state[3], state[4] = y, m, area, inside, at


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
        window = _window(averaging, timing, index)
        half = step / (2.0 * averaging) if averaging > 0.0 else 0.0
        decay = math.exp(-step / lag) if lag > 0.0 else 0.0
        rows.append((*window, half, decay, lag / step))
    size = max(row[0] for row in rows) + 2
    # As if x had rested at its level for ever: the rings end with the last step of a period.
    halves = np.array([row[3] for row in rows])
    areas = 2.0 * level * np.resize(halves[::-1], size)[::-1]
    inside = rows[-1][0]
    head = (level, level, areas[size - inside :].sum(), inside, size - 1)
    state = np.concatenate([head, np.full(size, level), areas])
    return Prepared(np.array(rows), state, timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Averaging alone and the filter alone, over few and over many samples."""
    times = [samples * scales.sample_period for samples in (0.7, 2.0, 6.0, 20.0, 60.0)]
    return [
        values
        for time in times
        for values in (
            {"averaging": time, "time_constant": 0.0},
            {"averaging": 0.0, "time_constant": time},
        )
    ]


def says(values: Values, scales: Scales) -> str:
    parts = {
        "averages over": values["averaging"],
        "has a time constant of": values["time_constant"],
    }
    longest = max(parts.values())
    shown = [f"{how} {quantity(s, 's')}" for how, s in parts.items() if s > SHOWN * longest]
    return f"the sensor lags: it {' and '.join(shown)}"


LINK = Link(
    name="sensor_lag",
    stage=Stage.SENSOR,
    order=10,
    title="lag of the sensor",
    source="definitions of a moving average and of a low-pass of first order",
    parameters=(
        Parameter("averaging", "s", 1e-3, 0.0, 1.0, "time over which a reading is averaged", 0.0),
        Parameter("time_constant", "s", 1e-3, 0.0, 1.0, "of the filter behind", 0.0),
    ),
    prepare=prepare,
    kernel=kernel,
    follows=True,
    starts=starts,
    says=says,
)
