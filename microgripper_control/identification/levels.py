"""The levels of a coarse sensor or converter, as far as its readings lie on them."""

from __future__ import annotations

import numpy as np

from microgripper_control.core.signals import Array

FINEST = 1e-5  # of the stroke: steps below this are not a sensor's
ON_GRID = 0.02  # of a step: how far a reading may lie off the grid, rounding of the file included
FEWEST = 8  # distinct readings, or steps in their range; fewer tell nothing about a grid
OFTEN, AGAIN = 4.0, 2.0  # times that a level is read, and come back to: one merely late is not


def step_between(readings: Array) -> float:
    """The usual step between the levels that readings, m, lie on or come back to; 0 if on none."""
    values = np.unique(readings)
    return _even_step(values) or _usual_step(readings, values)


def rounding_of(readings: Array) -> float:
    """What rounding to their own levels leaves in readings, m rms; 0 if they lie on none."""
    return step_between(readings) / float(np.sqrt(12.0))


def _even_step(values: Array) -> float:
    """The step of the grid that different readings lie on, m; 0 if on none."""
    steps = np.diff(values)
    steps = steps[steps > FINEST * np.ptp(values)]
    if len(values) < FEWEST or len(steps) < 0.5 * (len(values) - 1):
        return 0.0
    step = float(np.median(steps[steps < 1.5 * np.min(steps)]))
    for _ in range(3):  # the grid's step from ever longer distances
        counts = np.rint((values - values[0]) / step)
        step = float((values - values[0]) @ counts / (counts @ counts))
    off = np.abs((values - values[0]) / step - counts)
    return step if float(np.max(off)) < ON_GRID else 0.0


def _usual_step(readings: Array, values: Array) -> float:
    """The step between levels that readings come back to, m: steps of a few sizes; 0 if on none."""
    visits = 1 + np.count_nonzero(np.diff(readings))
    often = len(readings) > OFTEN * len(values) and visits > AGAIN * len(values)
    return float(np.median(np.diff(values))) if len(values) >= FEWEST and often else 0.0
