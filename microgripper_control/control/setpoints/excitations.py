"""Multisine and chirp: signals that excite a band of frequencies, for identification."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from microgripper_control.control.declared import declared
from microgripper_control.control.setpoints.base import Ranged, Ticks, whole_ticks
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array

SCHROEDER = -1  # in place of a seed


@dataclass(frozen=True)
class Multisine(Ranged):
    """All harmonics of 1/`period` in a band, of equal amplitude, scaled to fill low .. high.

    Without a seed the phases are Schroeder's (IEEE Trans. Inf. Theory 16, 1970), which keep the
    crest low: phase[i] = -pi i (i - 1) / tones. One period is a whole number of samples and begins
    at `low`.

    Raises MicrogripperError when asked for samples of a band with no harmonic in it or one that
    reaches half the sampling rate.
    """

    period: float = declared("s", 1.0, 1e-6, 1e5, "after which it repeats")
    lowest: float = declared("Hz", 1.0, 0.0, 1e5, "lower end of the band")
    highest: float = declared("Hz", 50.0, 1e-6, 1e5, "upper end of the band")
    seed: float = declared("1", SCHROEDER, SCHROEDER, 2**31, "random phases; -1: none", whole=True)

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        table = _one_period(self, sample_period)
        return table[k % len(table)]


@lru_cache(maxsize=8)
def _one_period(signal: Multisine, sample_period: float) -> Array:
    count = whole_ticks(signal.period, sample_period)
    period = count * sample_period
    slack = 1e-9  # a band that ends on a harmonic includes it
    first = max(1, math.ceil(signal.lowest * period - slack))
    last = math.floor(signal.highest * period + slack)
    if first > last or 2 * last >= count:
        raise MicrogripperError(
            f"Multisine: lowest .. highest = {signal.lowest:g} .. {signal.highest:g} Hz must hold "
            f"a harmonic of {1.0 / period:g} Hz and end below {0.5 / sample_period:g} Hz"
        )
    tones = last - first + 1
    i = np.arange(1, tones + 1)
    if signal.seed == SCHROEDER:
        phases = -np.pi * i * (i - 1) / tones
    else:
        phases = np.random.default_rng(int(signal.seed)).uniform(0.0, 2.0 * np.pi, tones)
    spectrum = np.zeros(count // 2 + 1, dtype=complex)
    spectrum[first : last + 1] = np.exp(1j * phases)
    wave = np.fft.irfft(spectrum, count)
    wave = np.roll(wave, -int(np.argmin(wave)))
    table = signal.between((wave - wave[0]) / (wave.max() - wave[0]))
    table.setflags(write=False)
    return table


@dataclass(frozen=True)
class Chirp(Ranged):
    """A sine from `low` at rest whose frequency runs straight from one value to another.

    f(t) = first + (last - first) t / duration, then `last` for good.
    """

    first: float = declared("Hz", 0.1, 0.0, 1e5, "frequency at the start")
    last: float = declared("Hz", 10.0, 0.0, 1e5, "frequency at the end")
    duration: float = declared("s", 10.0, 1e-6, 1e6, "time from first to last")

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        span = whole_ticks(self.duration, sample_period) * sample_period
        time = k * sample_period
        swept = np.minimum(time, span)
        cycles = self.first * swept + (self.last - self.first) * swept * swept / (2.0 * span)
        cycles = np.mod(cycles + self.last * (time - swept), 1.0)
        return self.between(0.5 - 0.5 * np.cos(2.0 * np.pi * cycles))
