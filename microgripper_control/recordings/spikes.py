"""Single readings that stand far off those around them: a lost bit, a loose plug, no motion.

A finger with a mass that goes somewhere and back within two samples was driven there: a reading
counts as a spike only if, on its scale, the voltage went straight on, and so do the readings before
and after it. Of many, some come so close that one is among those around another. Where there are
more yet they are no accident, and are left alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array

FAR = 12.0  # times the usual distance from the middle of the neighbours, and steps of the grid
OTHER_MOMENT = 1.5  # samples' travel: less may be a reading of another moment
ALIKE = 0.25  # of the spike: how near a line the readings around it, and what is asked for, are
BEFORE, AFTER = 3, 2  # samples around it that are looked at
AROUND = np.array([*range(-BEFORE, 0), *range(1, AFTER + 1)])
ALL_BUT_ONE = tuple(np.delete(AROUND, i) for i in range(len(AROUND)))
ENOUGH = 4096  # samples that tell what is usual
TOO_MANY = 0.1  # of the samples, far off: without noise, what is far tells nothing
MOST = 0.01  # of the samples: more are no accident
PAIRED = 0.2  # of the others: so many may have one spike among those around them
FASTEST = 0.01  # of the samples tell how far the rig goes for a volt,
ANSWER = 3  # samples later, or less


@np.errstate(all="ignore")  # what a damaged file holds may overflow
def spikes(voltage: Array, displacement: Array) -> NDArray[np.intp]:
    """Where readings, m, shape (n,), are spikes while the voltage, V, is applied."""
    off = np.abs(displacement[1:-1] - 0.5 * (displacement[:-2] + displacement[2:]))
    usual = float(np.median(off[:: 1 + len(off) // ENOUGH]))
    places = 1 + np.flatnonzero(off > FAR * usual)
    places = places[(places >= BEFORE) & (places < len(displacement) - AFTER)]
    if not 0 < len(places) < TOO_MANY * len(displacement):
        return places[:0]
    changes = np.abs(np.diff(displacement))
    step = float(np.min(changes[changes > 0.0]))
    asked = _Course.of(voltage, places, AROUND)
    applied = _gain(voltage, displacement) * np.maximum(asked.off, asked.bent)

    def alone(around: NDArray[np.intp]) -> NDArray[np.bool_]:
        course = _Course.of(displacement, places, around)
        straight = np.maximum(course.bent, applied) < ALIKE * course.off
        far = np.maximum(FAR * max(usual, step), OTHER_MOMENT * course.speed)
        return np.asarray(straight & (course.off > far))

    single = alone(AROUND)
    paired = np.any([alone(around) for around in ALL_BUT_ONE], axis=0) & ~single
    few = np.count_nonzero(paired) <= PAIRED * np.count_nonzero(single)
    places = places[single | paired] if few else places[single]
    return places if len(places) <= max(1.0, MOST * len(displacement)) else places[:0]


def _gain(voltage: Array, displacement: Array) -> float:
    """How far readings, m, go for each volt where the voltage moves fastest, which is no spike."""
    moved = np.abs(voltage[1:-ANSWER] - voltage[: -ANSWER - 1])
    few = max(1, int(FASTEST * len(moved)))
    fastest = np.argpartition(moved, -few)[-few:]
    after = displacement[fastest[:, None] + np.arange(1, ANSWER + 2)]
    answers = np.max(np.abs(after - displacement[fastest, None]), axis=1)
    return float(np.median(answers / np.maximum(moved[fastest], 1e-300)))


class _Course(NamedTuple):
    """A line through the samples around some places, shape (places,) each."""

    off: Array  # how far the signal is off it there,
    bent: Array  # at most around them,
    speed: Array  # and how far it goes from one sample to the next

    @classmethod
    def of(cls, signal: Array, places: NDArray[np.intp], around: NDArray[np.intp]) -> _Course:
        middle, slope = np.linalg.pinv(np.column_stack([np.ones(len(around)), around]))
        near = signal[places[:, None] + around]
        level, rise = near @ middle, near @ slope
        bent = near - level[:, None] - rise[:, None] * around
        off = np.abs(signal[places] - level)
        return cls(off, np.max(np.abs(bent), axis=1), np.abs(rise))
