"""A voltage between its samples, as the band-limited signal through them.

What follows takes it as straight from corner to corner, so each sample period is divided as finely
as the voltage bends.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from microgripper_control.core.signals import Array

FINEST = 8  # divisions of a sample period
STRAIGHT = 3e-6  # of the swing: what a chord may be off the voltage, if a sample is not divided,
BENT = 3e-4  # and with fewer divisions, whose chords' mean is made up for
ROUNDING = 1e-9  # of the voltage: the swing of one that stays where it is
KEPT = 16  # voltages whose course is remembered: a fit asks for the same ones hundreds of times


class Course(NamedTuple):
    """The corners of a voltage, V, and how many of them there are in a sample period."""

    corners: Array
    divisions: int

    def ends(self, begin: int, end: int, fraction: float) -> Array:
        """The voltage, V, a `fraction` of the way from each sample in begin .. end to the next."""
        place = fraction * self.divisions
        before = min(int(place), self.divisions - 1)
        rows = self.corners[begin * self.divisions : end * self.divisions + 1]
        old = rows[before : -1 : self.divisions]
        new = rows[before + 1 :: self.divisions]
        found: Array = old + (place - before) * (new - old)
        return found


def course(voltage: Array, periodic: bool) -> Course:
    """The course of a voltage, V, shape (n,); that of a periodic one runs back to its first."""
    return _course(voltage.tobytes(), periodic)


@lru_cache(maxsize=KEPT)
def _course(samples: bytes, periodic: bool) -> Course:
    voltage = np.frombuffer(samples)
    fine = _period(voltage) if periodic else _continued(voltage)
    swing = max(float(np.ptp(voltage)), ROUNDING * float(np.max(np.abs(voltage))))
    divisions = FINEST
    for fewer, off in ((4, BENT), (2, BENT), (1, STRAIGHT)):
        if _farthest(fine[:: FINEST // fewer]) > off * swing:
            break
        divisions = fewer
    return Course(_for_chords(fine[:: FINEST // divisions], divisions), divisions)


def _farthest(corners: Array) -> float:
    """How far the chords from corner to corner are off a smooth course at most."""
    return float(np.max(np.abs(np.diff(corners, 2)), initial=0.0)) / 8.0


def _period(voltage: Array) -> Array:
    """FINEST points a sample period, up to where the next period begins."""
    fine = _finer(voltage)
    return np.append(fine, fine[:1])


def _continued(voltage: Array) -> Array:
    """The same of a voltage that is not periodic, up to its last sample.

    It is continued beyond its ends by point reflection, which keeps value and slope, so that
    nothing rings there.
    """
    there_and_back = np.concatenate([voltage, 2.0 * voltage[-1] - voltage[-2:0:-1]])
    drift = 2.0 * (voltage[-1] - voltage[0]) * np.arange(len(there_and_back)) / len(there_and_back)
    count = (len(voltage) - 1) * FINEST + 1
    slope = 2.0 * (voltage[-1] - voltage[0]) / (len(there_and_back) * FINEST)
    whole: Array = _finer(there_and_back - drift)[:count] + slope * np.arange(count)
    return whole


def _finer(period: Array) -> Array:
    """FINEST points for each of a period."""
    from scipy.signal import resample  # takes 0.4 s to import: not for a node

    found: Array = resample(period, len(period) * FINEST)
    return found


def _for_chords(corners: Array, divisions: int) -> Array:
    """Corners whose chords have, from sample to sample, the mean of a smooth course.

    A chord is off the course by h^2 u'' / 12 in the mean, which a slow plant would take for a
    change of the voltage. The samples stay where they are, for a fast one that has arrived when it
    is read.
    """
    moved: Array = corners.copy()
    if divisions > 1:
        moved[1:-1] -= divisions / (divisions - 1.0) / 12.0 * np.diff(corners, 2)
        moved[::divisions] = corners[::divisions]
    return moved
