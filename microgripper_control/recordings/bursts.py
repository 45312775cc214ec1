"""Bursts of noise: a switched motor or a radio that shakes the readings for a while, not the rig.

In a burst readings are white, far louder than usual, while the voltage goes on smoothly; elsewhere,
in the same place and at the same speed, they are as quiet as ever. What a rig does would come again
there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.runs import runs
from microgripper_control.core.signals import Array
from microgripper_control.recordings.white_noise import noise_by_differences

WINDOW = 16  # samples
LOUD = 2.5  # times the usual noise of a window, and more than a step of the readings
RUN = 3  # loud windows in a row, at the least
WHITE = 1.5  # how far noise told by third differences may be off that told by fifth ones
SMOOTH = 0.3  # of the noise: what the voltage's own bends would make of it
NEAR, SLOWER = 0.05, 0.5  # of the voltage's span, and of its speed: windows that are alike,
ENOUGH, ALIKE = 4096, 5  # of so many at most which so many must be,
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
    noise = noise_by_differences(shown, 5)
    changes = np.abs(np.diff(displacement))
    step = float(np.min(changes, where=changes > 0.0, initial=np.inf))  # of a grid, if there is one
    loud = noise > max(LOUD * float(np.median(noise)), step)
    gain = float(np.ptp(displacement)) / max(float(np.ptp(voltage)), 1e-300)  # m/V
    for run in runs(loud, RUN):
        quietest = np.min(noise[run])
        white = float(np.median(noise_by_differences(shown[run], 3))) / float(np.median(noise[run]))
        bent = gain * np.max(noise_by_differences(applied[max(0, run.start - 1) : run.stop], 3))
        if bent >= SMOOTH * quietest or not 1.0 / WHITE < white < WHITE:
            continue
        if _quiet_elsewhere(applied, loud, run):
            found[max(0, run.start - 1) * WINDOW : (run.stop + 1) * WINDOW] = True
    return found if np.mean(found) <= MOST else np.zeros_like(found)


def _in_windows(signal: Array) -> Array:
    return signal[: len(signal) // WINDOW * WINDOW].reshape(-1, WINDOW)


def _quiet_elsewhere(applied: Array, loud: Mask, run: slice) -> bool:
    """Whether windows outside a run, at its voltage and no slower, are mostly quiet."""
    others = np.arange(0, len(loud), 1 + len(loud) // ENOUGH)
    others = others[(others < run.start) | (others >= run.stop)]
    level, speed = _course(applied[others])
    own_level, own_speed = _course(applied[run])
    margin = NEAR * float(np.ptp(level))
    near = (np.min(own_level) - margin <= level) & (level <= np.max(own_level) + margin)
    alike = others[near & (speed >= SLOWER * np.mean(own_speed))]
    return bool(len(alike) >= ALIKE and np.mean(~loud[alike]) >= QUIET)


def _course(applied: Array) -> tuple[Array, Array]:
    """The mean voltage of each window, V, and how far it goes from one sample to the next."""
    speed: Array = np.abs(np.diff(applied, axis=1)).mean(axis=1)
    return applied.mean(axis=1), speed
