"""Readings that are none: clipped at the end of a range, or the one before once more.

A fit takes them for motion, so they are flagged. On a coarse grid a reading repeats itself by
right: only what stays longer than the voltage's own motion allows is told.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.levels import grid_of

LONGEST = 4  # equal readings in a row that noise or a slow voltage may give
MANY = 1e-3  # of the samples: fewer are not worth a word
FAR = 3.0  # steps of the grid: travel over which an equal reading is no rounding
MOVES = 1e-3  # of the range: travel of the voltage during the row


def reading_warnings(recording: Recording) -> Iterator[str]:
    """One line for clipped and one for repeated readings, if there are any."""
    clipped, repeated = 0, 0
    x = recording.measured
    low, high = float(np.min(x)), float(np.max(x))
    for first, last in _rows_of_equals(recording):
        if x[first] in (low, high):
            clipped += last - first
        else:
            repeated += last - first
    name, count = recording.name, len(recording)
    if clipped > MANY * count:
        yield (
            f"{name}: {clipped} readings ({clipped / count:.1%}) stand at the end of the sensor's "
            "range while the voltage moves: they look clipped"
        )
    if repeated > MANY * count:
        yield (
            f"{name}: {repeated} readings ({repeated / count:.1%}) repeat the one before while the "
            "voltage moves: they look stale"
        )


def _rows_of_equals(recording: Recording) -> Iterator[tuple[int, int]]:
    """First and last sample of each row of equal readings that the voltage does not explain.

    It must go on moving: one step of a staircase shows after as many samples as the rig is late.
    """
    x, u = recording.measured, recording.voltage
    change = np.flatnonzero(np.diff(x) != 0.0)
    firsts = np.concatenate([[0], change + 1])
    lasts = np.concatenate([change, [len(x) - 1]])
    gain = float(np.ptp(x) / np.ptp(u)) if np.ptp(u) > 0.0 else 0.0
    step = grid_of([recording]).step
    allowed = max(MOVES * float(np.ptp(u)), FAR * step / gain if gain > 0.0 else 0.0)
    moved = np.cumsum(np.concatenate([[False], u[1:] != u[:-1]]))
    long = moved[lasts] - moved[firsts] >= LONGEST
    for first, last in zip(firsts[long], lasts[long], strict=True):
        if np.ptp(u[first : last + 1]) > allowed:
            yield int(first), int(last)
