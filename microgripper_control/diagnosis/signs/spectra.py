"""Spectra of residuals that are known on separate stretches of time only.

Every stretch is transformed by itself: zeros in place of what does not count would smear a strong
slow part over the whole spectrum.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.signal import detrend
from scipy.signal.windows import hann

from microgripper_control.core.recording import same_period
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual

SHORTEST = 64  # samples of a stretch that is looked at
NEARLY_ALL = 0.9  # of the samples: so many lie in stretches of a common length or longer
AT_ONCE = 16_384  # samples that are transformed together
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


def common_stretch(residuals: Sequence[Residual]) -> int:
    """The samples of the shortest stretches but those that hold next to nothing; 0 for none.

    A sample that is missing cuts off few others: they do not make all of the spectrum coarse.
    """
    runs = [run for residual in residuals for run in residual.runs(SHORTEST)]
    lengths = np.sort([run.stop - run.start for run in runs])[::-1]
    held = np.cumsum(lengths)
    return int(lengths[np.searchsorted(held, NEARLY_ALL * held[-1])]) if len(held) else 0


def spectrum_of(residuals: Sequence[Residual], length: int | None = None) -> Spectrum | None:
    """The spectra of residuals of one sample period, by Welch's method; None for no stretch.

    Stretches are cut to `length` samples, at most what nearly all of them have; it is the default.
    """
    period = residuals[0].period
    common = common_stretch(residuals)
    if not common:
        return None
    size = common if length is None else min(length, common)
    window = hann(size, sym=False)
    scale = 2.0 * period / float(window @ window)
    padded = 1 << (PADDING * size - 1).bit_length()
    error, motion, voltage = np.zeros((3, padded // 2 + 1))
    cross, count = np.zeros(padded // 2 + 1, dtype=complex), 0
    runs = [(residual, run) for residual in residuals for run in residual.runs(max(size, SHORTEST))]
    for residual, run in runs:
        signals = residual.error, residual.predicted, residual.recording.voltage
        pieces = [sliding_window_view(one[run], size)[:: max(1, size // 2)] for one in signals]
        for some in _some_at_once(len(pieces[0]), size):
            e, x, u = (np.fft.rfft(window * detrend(one[some]), padded) for one in pieces)
            error += np.sum(np.abs(e) ** 2, axis=0)
            motion += np.sum(np.abs(x) ** 2, axis=0)
            voltage += np.sum(np.abs(u) ** 2, axis=0)
            cross += np.sum(np.conj(x) * e, axis=0)
            count += len(e)
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


def _some_at_once(count: int, size: int) -> Iterator[slice]:
    """Slices of `count` pieces of `size` samples: not one by one, not all in memory at once."""
    some = max(1, AT_ONCE // size)
    for first in range(0, count, some):
        yield slice(first, first + some)


def same_clock(residuals: Sequence[Residual]) -> list[list[Residual]]:
    """Residuals in groups of one sample period each."""
    groups: list[list[Residual]] = []
    for residual in sorted(residuals, key=lambda one: one.period):
        if groups and same_period(groups[-1][0].period, residual.period):
            groups[-1].append(residual)
        else:
            groups.append([residual])
    return groups
