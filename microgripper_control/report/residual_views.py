"""A residual seen from its sides: spectrum, over displacement and rate, over holds, over voltage.

All take the residual of one recording, m, shape (n,), and the samples of it that count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import welch

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import STILL
from microgripper_control.identification.nuisance import Mask
from microgripper_control.plant.hold import Hold

LONGEST_SEGMENT = 2**20  # samples of a spectrum
SEGMENTS = 4  # of a recording, half overlapping
BANDS_PER_DECADE = 60
COLUMNS, ROWS = 36, 21  # of the map
FEWEST, MANY = 5, 20  # samples behind a mean that is shown: a cell's, a band's
RATE_SPAN = 5  # samples over which a rate is taken
SHORTEST_HOLD = 20  # samples
HOLD_BANDS_PER_DECADE = 8
VOLTAGE_BANDS = 60


@dataclass(frozen=True)
class Spectrum:
    """Amplitude density of a residual, averaged in narrow bands of equal width in log frequency."""

    frequency: Array  # Hz, shape (p,)
    density: Array  # m/sqrt(Hz), shape (p,)


def spectrum(residual: Array, counts: Mask, sample_period: float) -> Spectrum:
    """The residual's one-sided amplitude density, in the time that counts.

    What does not count is set to its mean.
    """
    level = np.mean(residual[counts]) if np.any(counts) else 0.0
    length = min(len(residual), LONGEST_SEGMENT, max(256, len(residual) // SEGMENTS))
    frequency, power = welch(np.where(counts, residual, level), 1.0 / sample_period, nperseg=length)
    frequency, power = frequency[1:], power[1:] / max(float(np.mean(counts)), 1e-9)
    band = np.floor(BANDS_PER_DECADE * np.log10(frequency / frequency[0]) + 0.5).astype(int)
    number = np.bincount(band)
    held = number > 0
    mean_power = np.bincount(band, power)[held] / number[held]
    middle = np.bincount(band, np.log(frequency))[held] / number[held]
    return Spectrum(np.exp(middle), np.sqrt(np.maximum(mean_power, np.finfo(float).tiny)))


def white_density(rms: float, sample_period: float) -> float:
    """Amplitude density, m/sqrt(Hz), of white noise of that rms, m."""
    return rms * float(np.sqrt(2.0 * sample_period))


def answered_voltage(recording: Recording, hold: Hold) -> Array:
    """The voltage, V, that each sample of the displacement answers to, shape (n,)."""
    voltage = recording.voltage
    return np.append(voltage[:1], voltage[:-1]) if hold is Hold.ZERO else voltage


def rate_of(voltage: Array, sample_period: float) -> Array:
    """How fast a voltage changes, V/s, shape (n,)."""
    rate = np.gradient(voltage, sample_period)
    smooth: Array = uniform_filter1d(rate, min(RATE_SPAN, len(rate)), mode="nearest")
    return smooth


@dataclass(frozen=True)
class Grid:
    """The cells of a map: equal steps of displacement, and of the rate's inverse hyperbolic sine.

    Rates run over decades and through zero; below `knee` (V/s) the scale is straight.
    """

    low: float  # m
    high: float
    knee: float  # V/s
    top: float  # of asinh(|rate| / knee)
    cell: np.ndarray[tuple[int], np.dtype[np.int64]]  # of each sample, shape (n,)

    @classmethod
    def of(cls, position: Array, voltage: Array, sample_period: float) -> Grid:
        """The grid that holds a course, m, with the voltage it answers to."""
        rate = rate_of(voltage, sample_period)
        size = np.abs(rate)
        largest = float(np.max(size))
        moving = size[size > 1e-6 * largest]
        knee = float(np.median(moving)) / 3.0 if len(moving) else 1.0
        top = float(np.arcsinh(largest / knee)) or 1.0
        low, high = float(np.min(position)), float(np.max(position))
        column = COLUMNS * (position - low) / (high - low)
        row = ROWS * (np.arcsinh(rate / knee) / top + 1.0) / 2.0
        whole = [
            np.clip(part.astype(np.int64), 0, count - 1)
            for part, count in ((column, COLUMNS), (row, ROWS))
        ]
        return cls(low, high, knee, top, whole[1] * COLUMNS + whole[0])

    def position(self, rate: float) -> float:
        """Where a rate, V/s, lies on the map's rows, 0 .. 1."""
        return (float(np.arcsinh(rate / self.knee)) / self.top + 1.0) / 2.0

    def mean(self, residual: Array, counts: Mask) -> Array:
        """Mean residual of each cell, m, shape (ROWS, COLUMNS); NaN where too few samples lie."""
        cells, size = self.cell[counts], ROWS * COLUMNS
        return _mean(cells, residual[counts], size).reshape(ROWS, COLUMNS)


def _mean(
    band: np.ndarray[tuple[int], np.dtype[np.int64]], values: Array, size: int, fewest: int = FEWEST
) -> Array:
    number = np.bincount(band, minlength=size)
    total = np.bincount(band, values, minlength=size)
    return np.where(number >= fewest, total / np.maximum(number, 1), np.nan)


@dataclass(frozen=True)
class Holds:
    """The samples at which the voltage rests after a change."""

    index: np.ndarray[tuple[int], np.dtype[np.int64]]  # of the samples, shape (p,)
    since: Array  # s, since the voltage came to rest, shape (p,)
    sign: Array  # of the change before it, +1 or -1, shape (p,)

    @classmethod
    def of(cls, recording: Recording) -> Holds:
        """The holds of a recording that are long enough to show something."""
        change = np.diff(recording.voltage)
        corners = np.flatnonzero(np.abs(change) > STILL * np.max(np.abs(change)))
        lengths = np.diff(np.append(corners, len(change)))
        long = corners[lengths >= SHORTEST_HOLD]
        spans = lengths[lengths >= SHORTEST_HOLD]
        parts = [np.arange(1, count) for count in spans]
        if not parts:
            return cls(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))
        ticks = np.concatenate(parts)
        index = np.repeat(long + 1, spans - 1) + ticks
        sign = np.repeat(np.sign(change[long]), spans - 1)
        return cls(index, recording.sample_period * ticks, sign)

    def course(self, residual: Array, counts: Mask) -> tuple[Array, Array]:
        """Time since rest, s, and the mean residual there, m, positive along the last change."""
        used = counts[self.index]
        if not np.any(used):
            return np.zeros(0), np.zeros(0)
        since = self.since[used]
        shortest = float(np.min(since))
        band = np.floor(HOLD_BANDS_PER_DECADE * np.log10(since / shortest) + 0.5).astype(np.int64)
        size = int(np.max(band)) + 1
        mean = _mean(band, (self.sign * residual[self.index])[used], size)
        middle = np.exp(_mean(band, np.log(since), size))
        held = np.isfinite(mean)
        return middle[held], mean[held]


def over_voltage(
    residual: Array, voltage: Array, counts: Mask, rising: bool
) -> tuple[Array, Array]:
    """Voltage, V, and the mean residual there, m, while it rises, or while it falls."""
    rate = rate_of(voltage, 1.0)
    used = counts & (rate > 0.0 if rising else rate < 0.0)
    low, high = float(np.min(voltage)), float(np.max(voltage))
    band = (VOLTAGE_BANDS * (voltage[used] - low) / (high - low)).astype(np.int64)
    mean = _mean(np.minimum(band, VOLTAGE_BANDS - 1), residual[used], VOLTAGE_BANDS, MANY)
    middle = low + (high - low) * (np.arange(VOLTAGE_BANDS) + 0.5) / VOLTAGE_BANDS
    held = np.isfinite(mean)
    return middle[held], mean[held]
