"""The grid that readings lie on: a sensor or converter that shows steps of one size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import Array

FINEST = 1e-5  # of the stroke: steps below this are not a sensor's
ON_GRID = 0.02  # of a step: how far a reading may lie off the grid, rounding of the file included
FEWEST = 8  # distinct readings, or steps in their range; fewer tell nothing about a grid
BINS = 1 << 16  # of the range of all readings
SHARP = 0.4  # how far a comb's density follows its step, noise of a fifth of a step and less,
ALONE = 0.6  # and how far, of that, it may follow any other
BOWED = 0.15  # of a step, rms: what a real converter's grid is off an even one
A_STEP, OFTEN = 1.2, 4.0  # values, if they are no more than a grid has; how often each is read,
AGAIN = 2.0  # and how often it is come back to: a reading that is merely late is not
TOO_CLOSE = 0.8  # of what rounding leaves: readings that follow a model closer are on no such grid


def rounding(step: float) -> float:
    """What readings on a grid of a step, m, are off the position, m rms."""
    return step / float(np.sqrt(12.0))


def unrounded(error: float, step: float) -> float:
    """What is left of an error, m rms, without what a grid of a step, m, bowed or not, adds."""
    return float(np.sqrt(max(error**2 - rounding(step) ** 2 - (BOWED * step) ** 2, 0.0)))


def noise_under(floor: float, step: float) -> float:
    """The noise, m rms, of a sensor whose readings have an innovation, m, and lie on a grid.

    Rounding looks like noise, but it is the grid's doing. Below the bow nothing can be told.
    """
    return min(floor, max(unrounded(floor, step), BOWED * step))


def refuted(step: float, error: float, readings: Sequence[Array]) -> bool:
    """Whether readings that follow some model with an error, m rms, cannot have such a step, m.

    A comb of positions can be the excitation's: a staircase of equal steps has one as well. Where
    the readings are no more values than the grid has, it is theirs, however close a model comes: at
    a few levels a flexible one follows the rounding itself.
    """
    close = error < TOO_CLOSE * rounding(step)
    return close and not all(_rounded(one, step) for one in readings)


def _rounded(displacement: Array, step: float) -> bool:
    """Whether there is hardly more than one value for each step, m, and that is read often."""
    values = len(np.unique(displacement))
    return values < min(A_STEP * (np.ptp(displacement) / step + 1.0), len(displacement) / OFTEN)


def common_step(readings: Sequence[Array]) -> float:
    """The step of the grid that at least half of some recordings show, m; 0 if there is none.

    Of a converter whose steps are not all alike, the usual one.
    """
    found = sorted(_exact_step(one) or _usual_step(one) for one in readings)
    return found[len(found) // 2] or _comb_step(readings)


def resolution(displacement: Array) -> float:
    """The step of the grid that all readings lie on or near, m; 0 if they do on none."""
    return common_step([displacement])


def _exact_step(displacement: Array) -> float:
    """The step of the grid that readings lie on."""
    values = np.unique(displacement)
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


def _usual_step(displacement: Array) -> float:
    """The step between levels that readings come back to: steps of a few sizes."""
    values = np.unique(displacement)
    visits = 1 + np.count_nonzero(np.diff(displacement))
    often = len(displacement) > OFTEN * len(values) and visits > AGAIN * len(values)
    return float(np.median(np.diff(values))) if len(values) >= FEWEST and often else 0.0


def _comb_step(readings: Sequence[Array]) -> float:
    """The step of a grid with noise on top, which a cable or a second converter adds.

    The readings' density is then a comb: its spectrum has one line, and that line's multiples. The
    few places at which a staircase stays give many lines, but other ones in each recording.
    """
    widest = max(float(np.ptp(one)) for one in readings)
    if min(len(np.unique(one)) for one in readings) < FEWEST:
        return 0.0
    combs = [_density(one, widest) for one in readings]
    lines = np.mean([np.abs(np.fft.rfft(one))[: BINS // FEWEST] for one in combs], axis=0)
    lines[:FEWEST] = 0.0
    steps = int(np.argmax(lines))
    line, number = lines[steps], np.arange(len(lines))
    away = np.abs(number - steps * np.rint(number / steps)) > 3.0 * np.maximum(number / steps, 1.0)
    if line < SHARP or np.max(lines[away], initial=0.0) > ALONE * line:
        return 0.0
    near = steps + np.linspace(-0.5, 0.5, 41)
    turns = np.exp(2j * np.pi * np.outer(near, np.arange(BINS) / BINS))
    return widest / float(near[np.argmax(sum(np.abs(turns @ one) for one in combs))])


def _density(displacement: Array, widest: float) -> Array:
    """The square root of how often readings are in each of the bins of a range, m; sum 1."""
    low = float(np.min(displacement))
    density = np.sqrt(np.histogram(displacement, BINS, (low, low + widest))[0])
    return np.asarray(density / np.sum(density))
