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
STRAIGHT = 3e-6  # of the swing: what a chord may be off the voltage where fewer divisions do
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
    fine, before, after = _period(voltage) if periodic else _continued(voltage)
    for divisions in (1, 2, 4):
        corners = fine[:: FINEST // divisions]
        off = np.max(np.abs(np.diff(corners, 2)), initial=0.0) / 8.0
        if off < STRAIGHT * np.ptp(voltage):
            return Course(corners, divisions)
    return Course(_for_chords(fine, before, after), FINEST)


def _period(voltage: Array) -> tuple[Array, float, float]:
    """FINEST points a sample period, and the next ones before and after them."""
    fine = _finer(voltage)
    return np.append(fine, fine[:1]), fine[-1], fine[1]


def _continued(voltage: Array) -> tuple[Array, float, float]:
    """The same of a voltage that is not periodic.

    It is continued beyond its ends by point reflection, which keeps value and slope, so that
    nothing rings there.
    """
    there_and_back = np.concatenate([voltage, 2.0 * voltage[-1] - voltage[-2:0:-1]])
    drift = 2.0 * (voltage[-1] - voltage[0]) * np.arange(len(there_and_back)) / len(there_and_back)
    fine = _finer(there_and_back - drift)
    count = (len(voltage) - 1) * FINEST + 1
    slope = 2.0 * (voltage[-1] - voltage[0]) / (len(there_and_back) * FINEST)
    whole = fine[:count] + slope * np.arange(count)
    return whole, 2.0 * whole[0] - whole[1], 2.0 * whole[-1] - whole[-2]


def _finer(period: Array) -> Array:
    """FINEST points for each of a period."""
    from scipy.signal import resample  # takes 0.4 s to import: not for a node

    found: Array = resample(period, len(period) * FINEST)
    return found


def _for_chords(fine: Array, before: float, after: float) -> Array:
    """Corners whose chords have, from sample to sample, the mean of a smooth course.

    A chord is off the course by h^2 u'' / 12 in the mean, which a slow plant would take for a
    change of the voltage. The samples stay where they are, for a fast one that has arrived when it
    is read. `before` and `after` go on beyond the ends.
    """
    bend = np.diff(np.concatenate([[before], fine, [after]]), 2)
    bend[::FINEST] = 0.0
    share = FINEST / (FINEST - 1.0) / 12.0
    corners: Array = fine - share * bend
    return corners
