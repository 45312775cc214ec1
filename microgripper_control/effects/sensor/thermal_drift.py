"""Slow drift that the voltage does not explain: the rig warms up and its parts expand.

    y = x + amplitude (1 - exp(-t / time_constant))

Live, the drift is that of one thermal mass after a change of power or of surroundings, from the
start of the run on. A real one has more masses and a room that changes, and no two recordings share
its course. Predictions therefore leave the link out, and each recording is given a course of its
own: Catmull and Rom's spline, which between two knots knows of no others than these and the next on
either side. The knots lie where the tenths of a held-out recording meet, of which every second is
fitted: each is known from a tenth beside it, so that the course cannot run away in those that
judge, as it can between knots that lie anywhere. Over the last tenth, which judges, it goes
straight on.
"""

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

TENTHS = 10


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: samples so far."""
    amplitude, rate = coefficients[0, 0], coefficients[0, 1]
    for j in range(bus.shape[1]):
        bus[POSITION, j] -= amplitude * math.expm1(-rate * state[0])
        state[0] += 1.0


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: the drift begins with the run."""
    row = (values["amplitude"], timing.sample_period / values["time_constant"])
    return Prepared(np.array([row]), np.zeros(1), timing.ramped)


def courses(values: Values, time: Array) -> Array:
    """Splines through 1 at one knot and 0 at the others, shape (9, n).

    Their weights are what has drifted since the first sample until each knot, m.
    """
    from scipy.interpolate import CubicHermiteSpline  # takes 0.2 s to import: not for a node

    knots = time[0] + (time[-1] - time[0]) * np.arange(TENTHS) / TENTHS
    ones = np.eye(TENTHS)
    slopes = np.gradient(ones, knots[1] - knots[0], axis=0)
    before = np.minimum(time, knots[-1])
    shapes = CubicHermiteSpline(knots, ones, slopes)(before) + np.outer(time - before, slopes[-1])
    found: Array = shapes.T[1:]
    return found


def observed(values: Values, weights: Array, time: Array) -> Values:
    """One thermal mass as slow as the recording is long, which ends where the course did."""
    end = 2.0 * float(weights[-1]) - float(weights[-2])  # a tenth after the last knot
    amplitude = end / -math.expm1(-1.0)
    return {"amplitude": amplitude, "time_constant": float(time[-1] - time[0])}


def starts(scales: Scales) -> Sequence[Values]:
    """One: the course is each recording's own."""
    return [{}]


def says(values: Values, scales: Scales) -> str:
    return "the reading drifts slowly, whatever the voltage does"


LINK = Link(
    name="thermal_drift",
    stage=Stage.SENSOR,
    order=30,
    title="thermal drift",
    source="one thermal mass; splines: Catmull and Rom 1974",
    sampled=True,
    random=True,
    parameters=(
        Parameter("amplitude", "m", 1e-6, -1e-2, 1e-2, "drift in the end", 0.0, fitted=False),
        Parameter(
            "time_constant", "s", 60.0, 1e-3, 1e6, "time constant of the warming", fitted=False
        ),
    ),
    prepare=prepare,
    kernel=kernel,
    courses=courses,
    observed=observed,
    starts=starts,
    says=says,
)
