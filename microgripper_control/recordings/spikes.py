"""Single readings that stand far off those around them: a lost bit, a loose plug, no motion.

A finger with a mass that goes somewhere and back within two samples was driven there: a reading
counts as a spike only if, on its scale, the voltage went straight on, and so do the readings before
and after it. Where there are many of them they are no accident, and are left alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array

FAR = 30.0  # times the usual distance from the middle of the neighbours, and steps of the grid
ALIKE = 0.2  # of the spike: how near a line the readings around it, and what is asked for, are
BEFORE, AFTER = 3, 2  # samples around it that are looked at
AROUND = np.array([*range(-BEFORE, 0), *range(1, AFTER + 1)])
MIDDLE, SLOPE = np.linalg.pinv(np.column_stack([np.ones(len(AROUND)), AROUND]))  # of a line
ENOUGH = 4096  # samples that tell what is usual
TOO_MANY = 0.1  # of the samples, far off: without noise, what is far tells nothing
MOST = 1e-3  # of the samples: more are no accident
SPAN = (1.0, 99.0)  # per cent of the readings, which no spike reaches


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
    places = places[off[places - 1] > FAR * step]
    around = places[:, None] + AROUND
    spike, bent = _off_a_line(displacement, places, around)
    pulse, driven = _off_a_line(voltage, places, around)
    low, high = np.percentile(displacement, SPAN)
    gain = (high - low) / max(float(np.ptp(voltage)), 1e-300)  # m/V
    others = np.maximum(bent, gain * np.maximum(pulse, driven))
    found: NDArray[np.intp] = places[others < ALIKE * spike]
    return found if len(found) <= max(1.0, MOST * len(displacement)) else found[:0]


def _off_a_line(signal: Array, places: NDArray[np.intp], around: NDArray[np.intp]) -> list[Array]:
    """How far a signal is off the straight course around some places: there, and around them."""
    near = signal[around]
    middle, slope = near @ MIDDLE, near @ SLOPE
    off = near - middle[:, None] - slope[:, None] * AROUND
    return [np.abs(signal[places] - middle), np.max(np.abs(off), axis=1)]
