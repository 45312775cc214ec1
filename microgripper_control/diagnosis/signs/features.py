"""Courses that follow from the input, whatever the law: what a free-form model is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual
from microgripper_control.effects.transmission.backlash import played

TAPS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 18, 22, 27, 33, 40)  # samples
WINDOWS = 12  # from LEAST_WINDOW samples to LONGEST_WINDOW of a recording
LEAST_WINDOW = 6.0
LONGEST_WINDOW = 0.3
BENDS = 9  # of each signal
WIDTHS = (0.003, 0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.6)  # of the range: of the plays


@dataclass(frozen=True)
class Frame:
    """What features are scaled by: the same for every recording."""

    voltage: tuple[float, float]  # middle and half of the range, V
    position: tuple[float, float]  # the same of the prediction, m
    period: float  # s, of the taps
    longest: float  # s

    @classmethod
    def around(cls, residuals: Sequence[Residual]) -> Frame:
        """The frame of the recordings that are fitted."""
        return cls(
            voltage=_middle_and_half([r.recording.voltage for r in residuals]),
            position=_middle_and_half([r.predicted for r in residuals]),
            period=min(r.period for r in residuals),
            longest=max(r.recording.duration for r in residuals),
        )


def features(residual: Residual, frame: Frame) -> tuple[Array, ...]:
    """Courses that follow from the input, about 1 in size, in groups of shape (n, p)."""
    middle, half = frame.voltage
    v = (residual.recording.voltage - middle) / half
    middle, half = frame.position
    x = (residual.predicted - middle) / half
    shortest = LEAST_WINDOW * frame.period
    windows = np.geomspace(shortest, max(LONGEST_WINDOW * frame.longest, 2.0 * shortest), WINDOWS)
    scale = frame.period / residual.period
    groups: list[list[Array]] = [
        [v - _delayed(v, max(1, round(tap * scale))) for tap in TAPS],
        [v - _smooth(v, window / residual.period) for window in windows],
        _by_rate(v, x, windows, residual.period),
    ]
    for signal in (v, x):
        plays = [played(signal, 2.0 * width) for width in WIDTHS]
        groups.append([signal**power for power in (1, 2, 3)])
        groups.append([np.maximum(signal - bend, 0.0) for bend in np.linspace(-0.8, 0.8, BENDS)])
        groups.append([signal - play for play in plays])
        groups.append([play**power for play in plays[3:] for power in (2, 3)])
    return tuple(np.stack(columns, axis=1) for columns in groups)


def _by_rate(v: Array, x: Array, windows: Array, period: float) -> list[Array]:
    """How the width of the loop and the sign of the error go with the rate, over some windows."""
    columns: list[Array] = []
    for window in windows[:7:3]:
        rate = (v - _smooth(v, window / period)) / window
        size = float(np.sqrt(np.mean(rate**2))) or 1.0
        log = np.log1p(np.abs(rate / size) * 10.0)
        side = np.sign(rate) * log
        columns += [side, x * log, side * x, rate * np.abs(rate) / size**2]
    return columns


def _middle_and_half(signals: Sequence[Array]) -> tuple[float, float]:
    low = min(float(np.min(signal)) for signal in signals)
    high = max(float(np.max(signal)) for signal in signals)
    return (low + high) / 2.0, (high - low) / 2.0 or 1.0


def _delayed(signal: Array, samples: int) -> Array:
    return np.concatenate([np.full(min(samples, len(signal)), signal[0]), signal[:-samples]])


def _smooth(signal: Array, samples: float) -> Array:
    """The mean over an exponential window of the past."""
    decay = float(np.exp(-1.0 / samples))
    start = np.array([decay * signal[0]])
    smoothed: Array = lfilter([1.0 - decay], [1.0, -decay], signal, zi=start)[0]
    return smoothed
