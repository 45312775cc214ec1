"""Hysteresis that widens with the rate of the voltage, about as its logarithm.

    w_r = w - strength log10(1 + r/reference) h,        memory r' = |u'| - r

The paper's h, which is what the loop is made of, is scaled by a rate r that forgets the past within
`memory`: a short one follows u' through the cycle, a long one scales the loop as a whole. Far above
`reference` each decade of the rate adds the share `strength`, far below the loop is the paper's. A
jump of a held voltage counts as its height, spread over `memory`.
"""

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent
from microgripper_control.core.signals import FREE, HYSTERESIS, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: the voltage so far and r."""
    steps = coefficients.shape[0]
    u, rate = state[0], state[1]
    for j in range(bus.shape[1]):
        c = coefficients[j % steps]
        rate = c[0] * rate + c[1] * abs(bus[VOLTAGE, j] - u)
        u = bus[VOLTAGE, j]
        bus[FREE, j] -= c[2] * math.log1p(rate * c[3]) * bus[HYSTERESIS, j]
    state[0], state[1] = u, rate


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: at rest the rate is zero."""
    memory, steps = values["memory"], np.array(timing.steps)
    decay = np.exp(-steps / memory)
    # From |change| of the voltage to r at the end: a constant rate, or an impulse at the start.
    gain = -np.expm1(-steps / memory) / steps if timing.ramped else decay / memory
    share = np.full(len(steps), values["strength"] / math.log(10.0))
    rows = np.column_stack([decay, gain, share, np.full(len(steps), 1.0 / values["reference"])])
    return Prepared(rows, np.array([levels[VOLTAGE], 0.0]), timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Memories from a few samples to the length of a recording."""
    shortest = 3.0 * scales.sample_period
    return [
        {"strength": 0.05, "memory": min(100.0, memory)}
        for memory in np.geomspace(shortest, max(scales.duration, 2.0 * shortest), 5)
    ]


def says(values: Values, scales: Scales) -> str:
    way = "widens" if values["strength"] >= 0.0 else "narrows"
    share = percent(abs(values["strength"]))
    return f"the hysteresis depends on the rate: the loop {way} by {share} per decade of rate"


LINK = Link(
    name="rate_dependent_hysteresis",
    stage=Stage.MATERIAL,
    order=20,
    title="hysteresis that widens with the rate",
    source="Ang, Khosla, Riviere 2007; Al Janaideh, Rakheja, Su 2011 (weights that follow rate)",
    parameters=(
        Parameter("strength", "1", 0.1, -1.0, 5.0, "share of h added in a decade of rate", 0.0),
        Parameter("memory", "s", 0.02, 1e-4, 100.0, "over which the rate is averaged"),
        Parameter("reference", "V/s", 10.0, 1e-6, 1e9, "from where the loop widens", fitted=False),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    says=says,
)
