"""Bursts of noise: a switched motor or a radio that shakes the readings for a while, not the rig.

In a burst readings are white, far louder than usual, while the voltage goes on smoothly; elsewhere,
in the same place and at the same speed, they are as quiet as ever. What a rig does would come again
there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import binom

from microgripper_control.core.signals import Array

WINDOW = 16  # samples
LOUD = 2.5  # times the usual noise of a window, and more than a step of the readings
RUN = 3  # loud windows in a row, at the least
WHITE = 1.5  # how far noise told by third differences may be off that told by fifth ones
SMOOTH = 0.3  # of the noise: what the voltage's own bends would make of it
NEAR, SLOWER = 0.05, 0.5  # of the voltage's span, and of its speed: windows that are alike,
ALIKE = 5  # of which so many there must be,
QUIET = 0.75  # and so large a share quiet
MOST = 0.2  # of the samples: more are no bursts

Mask = NDArray[np.bool_]


@np.errstate(all="ignore")  # what a damaged file holds may overflow
def bursts(voltage: Array, displacement: Array) -> Mask:
    """Which readings, m, shape (n,), are in bursts of noise while the voltage, V, is applied."""
    found = np.zeros(len(displacement), bool)
    if len(displacement) < ALIKE * WINDOW:
        return found
    shown, applied = _in_windows(displacement), _in_windows(voltage)
    noise = _noise(shown, 5)
    changes = np.abs(np.diff(displacement))
    step = float(np.min(changes, where=changes > 0.0, initial=np.inf))  # of a grid, if there is one
    loud = noise > max(LOUD * float(np.median(noise)), step)
    gain = float(np.ptp(displacement)) / max(float(np.ptp(voltage)), 1e-300)  # m/V
    bent = gain * _noise(applied, 3)
    for run in _runs(loud):
        quietest = np.min(noise[run])
        white = float(np.median(_noise(shown[run], 3))) / float(np.median(noise[run]))
        smooth = np.max(bent[max(0, run.start - 1) : run.stop]) < SMOOTH * quietest
        if smooth and 1.0 / WHITE < white < WHITE and _quiet_elsewhere(applied, loud, run):
            found[max(0, run.start - 1) * WINDOW : (run.stop + 1) * WINDOW] = True
    return found if np.mean(found) <= MOST else np.zeros_like(found)


def _in_windows(signal: Array) -> Array:
    return signal[: len(signal) // WINDOW * WINDOW].reshape(-1, WINDOW)


def _noise(windows: Array, order: int) -> Array:
    """The white noise of each window, told by differences of an order."""
    differences = np.diff(windows, order, axis=1)
    found: Array = np.sqrt(np.mean(differences**2, axis=1) / binom(2 * order, order))
    return found


def _runs(loud: Mask) -> list[slice]:
    """Windows in a row that are loud, RUN at the least."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], loud, [False]])))
    runs = [slice(int(first), int(last)) for first, last in ends.reshape(-1, 2)]
    return [run for run in runs if run.stop - run.start >= RUN]


def _quiet_elsewhere(applied: Array, loud: Mask, run: slice) -> bool:
    """Whether windows outside a run, at its voltage and no slower, are mostly quiet."""
    level = applied.mean(axis=1)
    speed = np.abs(np.diff(applied, axis=1)).mean(axis=1)
    low, high = np.min(level[run]), np.max(level[run])
    margin = NEAR * np.ptp(applied)
    alike = (
        (low - margin <= level) & (level <= high + margin) & (speed >= SLOWER * np.mean(speed[run]))
    )
    alike[run] = False
    return bool(np.count_nonzero(alike) >= ALIKE and np.mean(~loud[alike]) >= QUIET)
