"""Which samples of a periodic recording tell about the rig, and not about the time before it.

What a hysteretic material remembers from before the recording is unknown, and so is what a drive
does in the moment it is switched on. Where the voltage repeats itself both are gone after one
period: the habit of frequency response measurements (Pintelon and Schoukens 2012, chapter 2). But
the first period may be all that tells a lag, which a switch-on shows and a single sine does not,
from hysteresis; so it has its say before it is left out (see `resettling`).
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.identification.nuisance import Mask

SAME = 0.02  # of the swing, rms: so alike are two periods
ALIKE = 0.15  # the same before the period is known to a sample
FULL = 0.9  # of the swing: what a period must cover, and of a period: what must be left
BEGUN = 0.1  # of the way of the voltage: what lies before it becomes periodic at most
COARSE = 1500  # samples in which a period is looked for first,
FINER = 30  # times as finely then


def settled(recording: Recording) -> Mask:
    """The samples after the first period; all of them where the voltage is not periodic."""
    voltage = recording.voltage
    mask: Mask = np.ones(len(voltage), bool)
    period = find_period(voltage)
    if period:
        differs = np.abs(voltage[period:] - voltage[:-period]) > 2.0 * SAME * np.ptp(voltage)
        begin = int(np.flatnonzero(differs)[-1]) + 1 if differs.any() else 0
        way = np.abs(np.diff(voltage))
        left = len(voltage) - begin - period
        if left >= FULL * period and way[: max(0, begin - 1)].sum() <= BEGUN * way.sum():
            mask[: begin + period] = False
    return mask


def find_period(voltage: Array) -> int:
    """The shortest period, samples, that the end of a voltage has; 0 if it has none."""
    step = -(-len(voltage) // COARSE)
    coarse = voltage[len(voltage) % step :: step]
    apart = [_apart(coarse, period) for period in range(1, len(coarse) // 2 + 1)]
    for index, least in enumerate(apart):
        if least < ALIKE and least == min(apart[max(0, index - 1) : index + 2]):
            stride = -(-step // FINER)
            middle = _nearest(voltage, step * (index + 1), step, stride)
            period = _nearest(voltage, middle, stride, 1)
            if _apart(voltage, period) < SAME:
                return period
    return 0


def _nearest(voltage: Array, middle: int, reach: int, stride: int) -> int:
    """The length, samples, at most `reach` from `middle`, after which a voltage is most alike."""
    ways = range(-(reach // stride), reach // stride + 1)
    lengths = [middle + way * stride for way in ways if middle + way * stride > 0]
    return min(lengths, key=lambda length: _apart(voltage, length))


def _apart(voltage: Array, period: int) -> float:
    """The rms difference of the last two periods over the swing; infinite if they are not whole."""
    swing = np.ptp(voltage)
    if 2 * period > len(voltage) or not np.ptp(voltage[-period:]) >= FULL * swing > 0.0:
        return np.inf
    change = voltage[-period:] - voltage[-2 * period : -period]
    return float(np.sqrt(np.mean(change**2)) / swing)
