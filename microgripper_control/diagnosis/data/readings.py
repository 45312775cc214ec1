"""Readings that are none: clipped at the end of a range, or the one before once more.

A fit takes them for motion, so they are flagged, and where no others are equal they do not count.
On a coarse grid, or from a slow sensor, a reading repeats itself by right: only what stays longer
than the voltage's own motion allows is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.levels import grid_of

LONGEST = 4  # equal readings in a row that noise or a slow voltage may give
DEAD, LATE = 16, 8  # so many in a row, if no others are equal, for a single step, so long before
MANY = 1e-3  # of the samples: fewer are not worth a word
FAR = 3.0  # steps of the grid: travel over which an equal reading is no rounding
MOVES = 1e-3  # of the range: travel of the voltage during the row
SELDOM = 0.01  # of the samples: so many others may be equal by chance
MOST = 0.25  # of the samples: more do not go uncounted
BESIDE = 4  # samples next to clipped ones: noise shows there only towards the middle

UNCOUNTED = " and do not count"

Mask = NDArray[np.bool_]


class _Dead(NamedTuple):
    """Readings of one kind that are none."""

    what: str  # they do while the voltage moves,
    look: str  # and what they look like
    repeated: int  # how many repeat the one before
    samples: Mask  # shape (n,)

    def told(self, recording: Recording, left_out: bool) -> str:
        """A line for the reader."""
        share = f"{self.repeated / len(recording):.1%}"
        return (
            f"{recording.name}: {self.repeated} readings ({share}) {self.what} while the voltage "
            f"moves: they look {self.look}{UNCOUNTED if left_out else ''}"
        )


class Alive(NamedTuple):
    """Recordings without dead readings, a line for each kind of these, and whether any were."""

    recordings: list[Recording]
    lines: list[str]
    left_out: bool


def without_dead(recordings: Sequence[Recording]) -> Alive:
    """Leave out clipped and stale readings, of which each line says so by ending in UNCOUNTED.

    They count all the same where a coarse grid or a slow sensor repeats readings elsewhere.
    """
    checked = [_without_dead(recording) for recording in recordings]
    alive = [one for one, _ in checked]
    left_out = any(one is not before for one, before in zip(alive, recordings, strict=True))
    return Alive(alive, [line for _, lines in checked for line in lines], left_out)


def _without_dead(recording: Recording) -> tuple[Recording, list[str]]:
    count, x = len(recording), recording.measured
    rows, alone = _rows_of_equals(recording)
    ends = float(np.min(x)), float(np.max(x))
    clipped = _clipped(x, [row for row in rows if x[row.start] in ends])
    stale = _stale(x, [row for row in rows if x[row.start] not in ends])
    found = [dead for dead in (clipped, stale) if dead.repeated > MANY * count]
    left_out = alone and sum(dead.repeated for dead in found) <= MOST * count
    lines = [dead.told(recording, left_out) for dead in found]
    if not found or not left_out:
        return recording, lines
    dead = np.any([one.samples for one in found], axis=0)
    return replace(recording, read=recording.counting & ~dead), lines


def _clipped(x: Array, rows: Sequence[slice]) -> _Dead:
    limited = np.isin(x, [x[row.start] for row in rows])
    samples = binary_dilation(limited, iterations=BESIDE)
    return _Dead("stand at the end of the sensor's range", "clipped", _total(rows), samples)


def _stale(x: Array, rows: Sequence[slice]) -> _Dead:
    samples = np.zeros(len(x), bool)
    for row in rows:
        samples[row] = True
    return _Dead("repeat the one before", "stale", _total(rows), samples)


def _total(rows: Sequence[slice]) -> int:
    return sum(row.stop - row.start for row in rows)


def _rows_of_equals(recording: Recording) -> tuple[list[slice], bool]:
    """Rows of readings that repeat the one before and that the voltage does not explain.

    With them comes whether hardly any others repeat the one before, but at the ends of the range.
    """
    x, u = recording.measured, recording.voltage
    change = np.flatnonzero(np.diff(x) != 0.0)
    firsts = np.concatenate([[0], change + 1])
    lasts = np.concatenate([change, [len(x) - 1]])
    gain = float(np.ptp(x) / np.ptp(u)) if np.ptp(u) > 0.0 else 0.0
    step = grid_of([recording]).step
    allowed = max(MOVES * float(np.ptp(u)), FAR * step / gain if gain > 0.0 else 0.0)
    moved = np.cumsum(np.concatenate([[False], u[1:] != u[:-1]]))
    # The voltage must go on moving: one step shows after as many samples as the rig is late.
    goes_on = moved[lasts] - moved[firsts] >= LONGEST
    dead = lasts - firsts >= DEAD
    at_an_end = np.isin(x[firsts], (np.min(x), np.max(x)))  # a fast turn clips a few at a time
    others = int(np.sum((lasts - firsts)[~(dead | at_an_end)]))
    alone = others <= SELDOM * len(x)
    rows = []
    for at in np.flatnonzero(goes_on | (dead & alone)):
        first, last = int(firsts[at]), int(lasts[at])
        until = last if goes_on[at] else last - LATE
        if np.ptp(u[first : until + 1]) > allowed:
            rows.append(slice(first + 1, last + 1))
    return rows, alone
