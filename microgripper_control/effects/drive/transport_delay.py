"""Pure delay, fractions of a sample included.

    u(t) -> u(t - delay)

The reading may be held between conversions on a clock of the sensor's own (`conversion_clock`).

It stands before every other link because a delay commutes with all that do not depend on time.
Under a zero-order hold the delayed step falls inside a sample period; the link asks for an internal
boundary exactly there, so nothing is interpolated. A ramped signal is a chain of straight lines and
is read off between its corners.
"""

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values
from microgripper_control.effects.conversion_clock import CLOCK, says_clock

SHORT = 6  # first guesses within two samples
FOLLOWED = (0.01, 0.02, 0.03, 0.05)  # of a sample after a step: in between positions run straight
SAME_INSTANT = 1e-9  # of a sample period: boundaries closer than this are one


def jumps(values: Values, sample_period: float) -> set[float]:
    """Where in the sample period the delayed step falls, and where a stiff rig has followed it.

    The latter counts only if the sensor may convert in between.
    """
    fraction = math.fmod(values["delay"] / sample_period, 1.0)
    after = (0.0, *FOLLOWED) if values["clock"] > 0.0 else (0.0,)
    falls = {math.fmod(fraction + later, 1.0) for later in after}
    return {fall for fall in falls if SAME_INSTANT < fall < 1.0 - SAME_INSTANT}


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: where to write next, then a ring of the values at the end of past steps."""
    steps = coefficients.shape[0]
    size = state.shape[0] - 1
    write, row = int(state[0]), 0
    for j in range(bus.shape[1]):
        c = coefficients[row]
        state[1 + write] = bus[VOLTAGE, j]
        newer = write - int(c[0])
        newer = newer + size if newer < 0 else newer
        older = newer - 1 if newer > 0 else size - 1
        bus[VOLTAGE, j] = c[1] * state[1 + newer] + (1.0 - c[1]) * state[1 + older]
        write = write + 1 if write + 1 < size else 0
        row = row + 1 if row + 1 < steps else 0
    state[0] = write


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """One row per step: how many steps back the newer of two past values lies, and its weight."""
    period, ends = timing.sample_period, timing.ends
    # Ends of the steps back in time, newest first, far enough for the delay.
    back = math.ceil(values["delay"] / period) + 1
    rows = []
    for index, end in enumerate(ends):
        past = np.concatenate(
            [ends[index::-1], *(ends[::-1] - i * period for i in range(1, back + 1))]
        )
        wanted = end - values["delay"]
        # The step that contains the wanted instant ends at `past[at]`, the newest not before.
        at = int(np.flatnonzero(past >= wanted - SAME_INSTANT * period)[-1])
        if timing.ramped and at + 1 < len(past):
            span = past[at] - past[at + 1]
            weight = min(1.0, max(0.0, (wanted - past[at + 1]) / span)) if span > 0.0 else 1.0
        else:
            weight = 1.0
        rows.append((float(at), weight))
    ring = int(max(at for at, _ in rows)) + 2
    state = np.concatenate([[0.0], np.full(ring, levels[VOLTAGE])])
    return Prepared(np.array(rows), state, timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Early and late in a sample: steps of a held voltage are seen settled, or on their way."""
    found = [
        {"delay": (n + part) * scales.sample_period}
        for n in (*range(8), 10, 13, 17, 22, 30)
        for part in (0.4, 0.75, 0.9)
    ]
    if scales.clock > 0.0:
        cycles = [{"delay": n * scales.clock} for n in range(9)]
        found += [values | {"clock": scales.clock} for values in (*found[:SHORT], *cycles)]
    return found


def behind(values: Values) -> float:
    """The delay, and the half of a cycle that a reading of the sensor's clock is old on average."""
    return values["delay"] + 0.5 * values["clock"]


def says(values: Values, scales: Scales) -> str:
    delay = values["delay"]
    clauses = [f"there is a delay of {quantity(delay, 's')}"] if delay > 0.0 else []
    return f"the rig answers late: {', and '.join([*clauses, *says_clock(values)])}"


LINK = Link(
    name="transport_delay",
    stage=Stage.DRIVE,
    order=0,
    title="transport delay",
    source="definition of a pure delay",
    parameters=(
        Parameter(
            "delay", "s", 0.001, 0.0, 1.0, "time by which the command is late", 0.0, by_sample=True
        ),
        CLOCK,
    ),
    prepare=prepare,
    kernel=kernel,
    jumps=jumps,
    clocked=True,
    starts=starts,
    behind=behind,
    says=says,
)
