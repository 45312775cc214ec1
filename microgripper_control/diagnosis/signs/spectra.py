"""Spectra of residuals that are known on separate stretches of time only.

Every stretch is transformed by itself: zeros in place of what does not count would smear a strong
slow part over the whole spectrum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import detrend
from scipy.signal.windows import hann

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual

SHORTEST = 64  # samples of a stretch that is looked at
PADDING = 4  # times its length that a stretch is transformed with: finer steps along frequency


@dataclass(frozen=True)
class Spectrum:
    """Power densities on one grid of frequencies, shape (f,), means over all stretches."""

    frequency: Array  # Hz
    error: Array  # m^2/Hz
    motion: Array  # m^2/Hz, of the predicted displacement
    voltage: Array  # V^2/Hz
    cross: NDArray[np.complex128]  # m^2/Hz: conj(motion) error
    stretches: int
    resolution: float  # Hz, half the width of a line's main lobe
    period: float  # s

    @property
    def step(self) -> float:
        """Hz between two frequencies."""
        return float(self.frequency[1] - self.frequency[0])

    def power(self, low: float, high: float) -> float:
        """Of the error between two frequencies, m^2."""
        inside = (self.frequency >= low) & (self.frequency <= high)
        return float(np.sum(self.error[inside])) * self.step


def shortest_stretch(residuals: Sequence[Residual]) -> int:
    """The samples of the shortest stretch that is looked at; 0 for none."""
    return min((r.stop - r.start for one in residuals for r in one.runs(SHORTEST)), default=0)


def spectrum_of(residuals: Sequence[Residual], length: int | None = None) -> Spectrum | None:
    """The spectra of residuals of one sample period, by Welch's method; None for no stretch.

    Stretches are cut to `length` samples, by default that of the shortest of them.
    """
    period = residuals[0].period
    runs = [(residual, run) for residual in residuals for run in residual.runs(SHORTEST)]
    if not runs:
        return None
    shortest = shortest_stretch(residuals)
    size = shortest if length is None else min(length, shortest)
    window = hann(size, sym=False)
    scale = 2.0 * period / float(window @ window)
    padded = 1 << (PADDING * size - 1).bit_length()
    error, motion, voltage = np.zeros((3, padded // 2 + 1))
    cross, count = np.zeros(padded // 2 + 1, dtype=complex), 0
    for residual, run in runs:
        predicted = residual.recording.measured - residual.error
        for start in range(run.start, run.stop - size + 1, max(1, size // 2)):
            piece = slice(start, start + size)
            e = np.fft.rfft(window * detrend(residual.error[piece]), padded)
            u = np.fft.rfft(window * detrend(residual.recording.voltage[piece]), padded)
            x = np.fft.rfft(window * detrend(predicted[piece]), padded)
            error += np.abs(e) ** 2
            motion += np.abs(x) ** 2
            voltage += np.abs(u) ** 2
            cross += np.conj(x) * e
            count += 1
    factor = scale / count
    return Spectrum(
        frequency=np.asarray(np.fft.rfftfreq(padded, period), dtype=np.float64),
        error=factor * error,
        motion=factor * motion,
        voltage=factor * voltage,
        cross=np.asarray(factor * cross, dtype=np.complex128),
        stretches=count,
        resolution=2.0 / (size * period),
        period=period,
    )


def same_clock(residuals: Sequence[Residual]) -> list[list[Residual]]:
    """Residuals in groups of one sample period each."""
    periods = sorted({residual.period for residual in residuals})
    return [[one for one in residuals if one.period == period] for period in periods]
