"""The grid of a sensor read off its readings: they lie on levels, or gather about them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.grid import NO_GRID, Grid
from microgripper_control.identification.levels import AGAIN, FEWEST, step_between

BINS = 1 << 16  # of the range of all readings
SHARP = 0.4  # how far a comb's density follows its step, noise of a fifth of a step and less,
ALONE = 0.6  # and how far, of that, it may follow any other
ALONG = 0.5  # of how far readings go with the voltage: at a level of a grid they do not go,
LEAP, MOVES = 0.3, 0.03  # of a step: what goes on is no jump, and what there should be to go, rms
MISSING = 1.5  # usual steps: a wider one has a level within that is never shown,
CROSSED = 0.5  # if so much of what passes it goes from end to end, and more than a few times:
LEAPS = 2  # else it was leapt over,
OWNER = 1.5  # and is shown by that end, if by either, that is read so much oftener
CLEFT = 3.0  # times the widest gap of as many readings at random
GATHERED = 5  # readings at a level, at least, if noise was added to them
NARROW = 0.6  # of a step: how far these lie apart
MOSTLY = 0.8  # of the readings are at such levels

Indices = NDArray[np.intp]


def grid_of(recordings: Sequence[Recording]) -> Grid:
    """The grid that at least half of some recordings show; NO_GRID if there is none.

    Of a converter whose steps are not all alike, the usual one.
    """
    readings = [recording.measured for recording in recordings]
    if (grid := _of_half([_on_levels(one) for one in readings])) != NO_GRID:
        return grid
    if step := _comb_step(readings):
        bands = any(_goes_along(one, _nearest(one.measured, step), step) for one in recordings)
        return NO_GRID if bands else Grid.even(step)
    return _of_half([_gathered(one) for one in recordings])


def _of_half(grids: Sequence[Grid]) -> Grid:
    """The median of some grids, by their steps."""
    return sorted(grids)[len(grids) // 2]


def _on_levels(displacement: Array) -> Grid:
    """The grid that all readings lie on, or come back to."""
    if not (step := step_between(displacement)):
        return NO_GRID
    levels, walk = np.unique(displacement, return_inverse=True)
    return Grid(step, _left_by_rounding(levels, walk, step))


def _left_by_rounding(levels: Array, walk: Indices, step: float) -> float:
    """What rounding to levels leaves, m rms; `walk` is which of them each reading shows.

    Each level stands for the positions from half way to the one below to half way to the one above.
    """
    apart, counts = np.diff(levels), np.bincount(walk, minlength=len(levels))
    wide = apart > MISSING * step
    reach = 0.5 * np.where(wide, step, apart)
    below, above = np.append(0.5 * step, reach), np.append(reach, 0.5 * step)
    for index in np.flatnonzero(wide & _crossed(walk, len(levels))):
        shared = _shared(apart[index], step, counts[index], counts[index + 1])
        above[index], below[index + 1] = shared
    squares = (below**3 + above**3) / (3.0 * (below + above))  # uniform within each
    return float(np.sqrt(np.average(squares, weights=counts)))


def _crossed(walk: Indices, levels: int) -> NDArray[np.bool_]:
    """Whether the way from each level to the next is mostly gone by itself, shape (levels - 1,).

    Where steps of a staircase leap over levels it is not, nor does what leaps once or twice show.
    """
    low, high = np.minimum(walk[:-1], walk[1:]), np.maximum(walk[:-1], walk[1:])
    leaps = np.bincount(low, minlength=levels) - np.bincount(high, minlength=levels)
    passed = np.cumsum(leaps)[:-1]
    direct = np.bincount(low[high - low == 1], minlength=levels)[:-1]
    mostly: NDArray[np.bool_] = direct > np.maximum(CROSSED * passed, LEAPS)
    return mostly


def _shared(apart: float, step: float, lower: int, upper: int) -> tuple[float, float]:
    """How far two levels reach into a wide gap between them, m."""
    if lower > OWNER * upper:
        return apart - 0.5 * step, 0.5 * step
    if upper > OWNER * lower:
        return 0.5 * step, apart - 0.5 * step
    return 0.5 * apart, 0.5 * apart


def _comb_step(readings: Sequence[Array]) -> float:
    """The step of a grid with noise on top, which a cable or a second converter adds, m; or 0.

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


def _nearest(displacement: Array, step: float) -> Indices:
    """The number of the level of a grid, wherever that begins, at which each reading is."""
    turns = displacement / step
    phase = np.angle(np.mean(np.exp(2j * np.pi * turns))) / (2.0 * np.pi)
    return np.asarray(np.rint(turns - phase), dtype=np.intp)


def _goes_along(recording: Recording, level: Indices, step: float) -> bool:
    """Whether readings go with the voltage even while they stay at a `level`, which is none then.

    Of a converter with a bit that sticks whole bands of readings are missing, and a comb is left.
    Within a band they jump as well, by its width, but they go along in between.
    """
    caused, shown = recording.voltage[:-1], recording.measured[1:]
    leaves = (np.diff(level[1:]) != 0) | (np.abs(np.diff(shown)) > LEAP * step)
    stay = np.concatenate([[0], np.cumsum(leaves)])
    whole = _slope(caused - np.mean(caused), shown - np.mean(shown))
    caused, shown = _off_means(caused, stay), _off_means(shown, stay)
    moves = whole * float(np.sqrt(np.mean(caused**2))) > MOVES * step
    return moves and _slope(caused, shown) > ALONG * whole


def _off_means(values: Array, group: Indices) -> Array:
    """Values less the mean of each one's group."""
    means = np.bincount(group, values) / np.bincount(group)
    return np.asarray(values - means[group])


def _slope(caused: Array, shown: Array) -> float:
    power = float(caused @ caused)
    return float(caused @ shown) / power if power > 0.0 else 0.0


def _density(displacement: Array, widest: float) -> Array:
    """The square root of how often readings are in each of the bins of a range, m; sum 1."""
    low = float(np.min(displacement))
    density = np.sqrt(np.histogram(displacement, BINS, (low, low + widest))[0])
    return np.asarray(density / np.sum(density))


def _gathered(recording: Recording) -> Grid:
    """The grid of uneven steps about whose levels readings gather, with little noise on top.

    There are clefts between them then, wider than any gap of readings that lie at random. Looked at
    are those during which the voltage moves on: elsewhere they gather where it stays.
    """
    ways = np.sign(np.diff(recording.voltage))
    moving = recording.measured[1:-1][(ways[1:] == ways[:-1]) & (ways[1:] != 0.0)]
    readings = np.sort(moving)
    gaps = np.diff(readings)
    if len(gaps) == 0:
        return NO_GRID
    clefts = np.flatnonzero(gaps > CLEFT * np.log(len(readings)) * np.median(gaps))
    groups, walk = np.split(readings, clefts + 1), np.searchsorted(readings[clefts], moving)
    many = np.array([len(group) >= GATHERED for group in groups])
    visits = 1 + np.count_nonzero(np.diff(walk))
    if np.sum(many) < FEWEST or visits < AGAIN * np.sum(many):
        return NO_GRID
    groups = [group for group, gathered in zip(groups, many, strict=True) if gathered]
    levels = np.array([float(np.mean(group)) for group in groups])
    step = float(np.median(np.diff(levels)))
    narrow = [group for group in groups if np.ptp(group) < NARROW * step]
    if sum(len(group) for group in narrow) < MOSTLY * len(readings):
        return NO_GRID
    if _goes_along(recording, np.searchsorted(readings[clefts], recording.measured), step):
        return NO_GRID
    number = np.cumsum(many) - 1  # of the groups that are left
    return Grid(step, _left_by_rounding(levels, number[walk[many[walk]]], step))
