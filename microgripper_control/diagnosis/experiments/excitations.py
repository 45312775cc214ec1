"""Voltages that a laboratory records to look into a rig, made to a range and a sample period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import Array

FASTEST = 1 / 8  # of the sampling rate: the highest frequency of a sine,
FASTEST_LOOP = 1 / 40  # and of one whose loops are to be seen
MOST_FAST_SAMPLES = 8000  # of the fast courses; more of the same tells little more
RUNGS = 4  # rates of a ladder of loops
LEVELS = 3  # steps each way of a staircase
SQUARES = 5
DECAYING = 8  # loops
SMALLEST_LOOP = 0.1  # of the first, the last of the decaying ones
PART = (0.35, 0.65)  # of the range: a small amplitude


@dataclass(frozen=True)
class Excitation:
    """A voltage, V, shape (n,), and what to call it in a sentence."""

    description: str
    voltage: Array

    @property
    def fastest(self) -> float:
        """The largest change from one sample to the next, V."""
        return float(np.max(np.abs(np.diff(self.voltage))))


@dataclass(frozen=True)
class Reach:
    """What an experiment may use: a range of voltage, samples, and how sharp an edge may be."""

    low: float  # V
    high: float  # V
    sample_period: float  # s
    samples: int
    edge: int = 1  # samples from level to level

    @property
    def duration(self) -> float:
        """s, of the longest experiment."""
        return self.samples * self.sample_period

    def part(self) -> Reach:
        """The same with a small amplitude in the middle."""
        low, high = (self.low + share * (self.high - self.low) for share in PART)
        return Reach(low, high, self.sample_period, self.samples, self.edge)

    def course(self, share: Array) -> Array:
        """`low` where the share is 0, `high` where it is 1."""
        voltage: Array = self.low + (self.high - self.low) * np.clip(share, 0.0, 1.0)
        return voltage

    @property
    def text(self) -> str:
        """The range in words."""
        return f"from {quantity(self.low, 'V', 3)} to {quantity(self.high, 'V', 3)}"


def excitations(reach: Reach) -> list[Excitation]:
    """All of them, the gentle ones first; each begins settled at its first voltage."""
    part = reach.part()
    return [
        _rest(reach),
        _loops(reach),
        _decaying(reach),
        _staircase(reach),
        _square(reach, 1),
        _square(reach, SQUARES),
        _ladder(part),
        _ladder(reach),
        _chirp(part),
        _multisine(part),
        _chirp(reach),
        _multisine(reach),
    ]


def _rest(reach: Reach) -> Excitation:
    middle = 0.5 * (reach.low + reach.high)
    text = f"{quantity(reach.duration, 's')} at rest at {quantity(middle, 'V', 3)}"
    return Excitation(text, np.full(reach.samples, middle))


def _held(reach: Reach, levels: Array) -> Array:
    """Levels one after the other, each held as long, with edges of `reach.edge` samples."""
    position = np.arange(reach.samples) * len(levels) / reach.samples
    number = position.astype(int)
    since = (position - number) * reach.samples / len(levels)
    ramp = np.clip(since / reach.edge, 0.0, 1.0) if reach.edge > 1 else np.ones(reach.samples)
    before = levels[np.maximum(number - 1, 0)]
    return reach.course(before + (levels[number] - before) * 0.5 * (1.0 - np.cos(np.pi * ramp)))


def _staircase(reach: Reach) -> Excitation:
    up = np.arange(LEVELS + 1) / LEVELS
    levels = np.concatenate([up, up[-2::-1]])
    hold = reach.duration / len(levels)
    text = (
        f"a staircase {reach.text} and back in {LEVELS} steps each way, held {quantity(hold, 's')}"
    )
    return Excitation(text, _held(reach, levels))


def _square(reach: Reach, times: int) -> Excitation:
    levels = np.append(np.tile([0.0, 1.0], times), 0.0)
    hold = quantity(reach.duration / len(levels), "s")
    what = "a step" if times == 1 else f"{times} steps"
    return Excitation(f"{what} {reach.text} and back, held {hold} each", _held(reach, levels))


def _loops(reach: Reach) -> Excitation:
    cycles = 2.0 * np.arange(reach.samples) / reach.samples
    share = 1.0 - np.abs(2.0 * np.mod(cycles, 1.0) - 1.0)
    frequency = quantity(2.0 / reach.duration, "Hz")
    return Excitation(f"slow triangular loops {reach.text} at {frequency}", reach.course(share))


def _decaying(reach: Reach) -> Excitation:
    cycles = DECAYING * np.arange(reach.samples) / reach.samples
    size = SMALLEST_LOOP ** (cycles / DECAYING)
    share = 0.5 - 0.5 * size * np.cos(2.0 * np.pi * cycles)
    return Excitation(f"{DECAYING} ever smaller loops {reach.text}", reach.course(share))


def _ladder(reach: Reach) -> Excitation:
    """Sine loops at rates that grow from one part of the recording to the next."""
    count = reach.samples // RUNGS
    slowest = 1.0 / count
    cycles = np.geomspace(slowest, max(FASTEST_LOOP, slowest), RUNGS) * count
    time = np.arange(count) / count
    rungs = [np.mod(np.round(c) * time, 1.0) for c in cycles]
    share = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.concatenate(rungs))
    ends = (quantity(round(c) / count / reach.sample_period, "Hz") for c in cycles[[0, -1]])
    text = f"sine loops {reach.text} at {RUNGS} rates, {' to '.join(ends)}"
    return Excitation(text, reach.course(share))


def _chirp(reach: Reach) -> Excitation:
    count = min(reach.samples, MOST_FAST_SAMPLES)
    k = np.arange(count)
    share = 0.5 - 0.5 * np.cos(np.pi * FASTEST * k * k / count)
    highest = quantity(FASTEST / reach.sample_period, "Hz", 3)
    length = quantity(count * reach.sample_period, "s")
    text = f"a chirp {reach.text}, up to {highest} within {length}"
    return Excitation(text, reach.course(share))


def _multisine(reach: Reach) -> Excitation:
    """Two periods of all harmonics in the band, with Schroeder's phases, begun at the lowest."""
    count = min(reach.samples, MOST_FAST_SAMPLES) // 2
    tones = int(FASTEST * count)
    i = np.arange(1, tones + 1)
    spectrum = np.zeros(count // 2 + 1, dtype=complex)
    spectrum[1 : tones + 1] = np.exp(-1j * np.pi * i * (i - 1) / tones)
    wave = np.fft.irfft(spectrum, count)
    wave = np.roll(wave, -int(np.argmin(wave)))
    share = np.tile((wave - wave[0]) / np.ptp(wave), 2)
    highest = quantity(FASTEST / reach.sample_period, "Hz", 3)
    return Excitation(f"a multisine {reach.text}, up to {highest}", reach.course(share))
