"""Where along frequency the gap lies: lines, resonances, a band, or a drift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import REAL, Residual, gap_energy, gap_power
from microgripper_control.diagnosis.findings import Range
from microgripper_control.diagnosis.signs.spectra import (
    PADDING,
    Spectrum,
    common_stretch,
    same_clock,
    spectrum_of,
)

NOTHING = 1e-30  # m^2/Hz: below any sensor's noise
OWN = 0.3  # of the motion's density at a peak of the error, at least: else it is a share of it
OWN_LINE = 3.0  # the same of a line
HARMONICS = 15  # of the motion's main frequency that are not taken for peaks
MOST_PEAKS = 8  # that are looked at
LENGTHS = (400, 1600, 6400)  # samples of a stretch, to see broad resonances and narrow ones by
CONTRAST = 12.0  # of a peak over its neighbourhood, at least
NEIGHBOURS = 12.0  # resolutions: how wide the neighbourhood is
WORTH = 0.08  # of the gap: what a peak holds at least,
LINE = 0.02  # or of so much of the noise's power, for a line shows where no gap does
HALF_POWER = 0.36  # of the resolution: half the width of a pure line at half its height
MOST = 0.6  # of the gap: what a band holds at least
NARROW = 3.0  # its share over that of the voltage's power, and of the axis, at least
PER_OCTAVE = 4  # bins
SLOW = 0.2  # Hz: what is slower is called drift
DRIFTING = 0.5  # of the gap: what a drift holds at least,
DRIFTS = 4.0  # and as how concentrated it counts, for each share of the gap
BETTER = 0.6  # of what a function of the voltage leaves: what a slow course leaves at most


@dataclass(frozen=True)
class Band:
    """A range of frequencies; `concentration` is its share of the gap over what was expected."""

    place: Range
    concentration: float

    def within(self, share: float) -> Band:
        """The same of a gap of which that it was found in is a share."""
        place = replace(self.place, share_of_gap=share * self.place.share_of_gap)
        return Band(place, share * self.concentration)


def bands(residuals: Sequence[Residual], noise: float) -> list[Band]:
    """The parts of the spectrum that hold a good deal of the gap; `noise` in m."""
    total, energy = gap_power(residuals, noise), gap_energy(residuals, noise)
    found: list[Band] = []
    for group in same_clock(residuals):
        own = max(gap_power(group, noise), 0.0)
        spectrum = spectrum_of(group)
        peaks = _peaks(group, spectrum, noise, own)
        if not peaks and spectrum is not None and own > REAL * noise**2:
            peaks = _broad(spectrum, noise, own)
        share = min(1.0, max(0.0, gap_energy(group, noise)) / energy) if energy > 0.0 else 1.0
        found += [peak.within(share) for peak in peaks]
    drift = slow_share(residuals, noise)
    if total > REAL * noise**2 and drift >= DRIFTING:
        found.append(Band(Range("frequency_Hz", 0.0, SLOW, min(1.0, drift)), DRIFTS * drift))
    return found


def _peaks(
    group: Sequence[Residual], spectrum: Spectrum | None, noise: float, total: float
) -> list[Band]:
    """Lines, looked for in the spectrum that is as fine as the stretches allow, and resonances."""
    lines = [] if spectrum is None else [p for p in find_peaks(spectrum, noise) if p.line]
    peaks = [*lines, *(p for p in resonances(group, noise) if all(p.apart(one) for one in lines))]
    worth = WORTH * max(total, LINE * noise**2)
    peaks = sorted([p for p in peaks if p.power > worth], key=lambda peak: -peak.power)
    gap = max(total, sum(peak.power for peak in peaks))
    return [
        Band(Range("frequency_Hz", p.low, p.high, p.power / gap), p.contrast**0.5 * p.power / gap)
        for p in peaks[:2]
    ]


@dataclass(frozen=True)
class Peak:
    """A peak of the error's spectrum that is no share of the motion's."""

    frequency: float  # Hz
    low: float  # Hz, its range
    high: float
    power: float  # m^2, above its neighbourhood
    contrast: float  # height over its neighbourhood
    line: bool  # no wider than the spectrum's own resolution

    def apart(self, other: Peak) -> bool:
        """Whether their ranges do not meet."""
        return self.low > other.high or self.high < other.low


def resonances(group: Sequence[Residual], noise: float) -> list[Peak]:
    """The peaks that are no lines, of residuals of one sample period; the broadest are found first.

    What is narrower than a spectrum's resolution shows as a peak in one that is finer.
    """
    found: list[Peak] = []
    longest = common_stretch(group)  # the recordings allow no finer spectrum
    for length in sorted({min(length, longest) for length in LENGTHS}):
        spectrum = spectrum_of(group, length)
        peaks = [] if spectrum is None else find_peaks(spectrum, noise)
        found += [p for p in peaks if not p.line and all(p.apart(known) for known in found)]
    return found


def find_peaks(spectrum: Spectrum, noise: float) -> list[Peak]:
    """The peaks of the error that the motion does not explain, most power first."""
    floor = 2.0 * noise**2 * spectrum.period
    step, frequency = spectrum.step, spectrum.frequency
    density = spectrum.error + max(1e-3 * floor, NOTHING)
    wide = int(NEIGHBOURS * spectrum.resolution / step)
    around = _neighbourhood(density, wide)
    contrast = density / np.maximum(around, floor)
    # Of n values the largest of chance is ln(n) times the mean if nothing is averaged.
    chance = 1.0 + np.log(len(frequency)) * 2.0 / np.sqrt(spectrum.stretches)
    needed = max(CONTRAST if spectrum.stretches < 4 else CONTRAST / 3.0, 1.5 * chance)
    found: list[Peak] = []
    share = density / (spectrum.motion + floor)
    usual = _neighbourhood(share, wide)
    free = frequency >= 3.0 * spectrum.resolution
    for _ in range(MOST_PEAKS):
        at = int(np.argmax(np.where(free, contrast, 0.0)))
        if contrast[at] < needed:
            break
        peak = _peak(spectrum, density, around, at, float(contrast[at]))
        margin = 2.0 * spectrum.resolution
        free &= (frequency < peak.low - margin) | (frequency > peak.high + margin)
        own = density[at] > (OWN_LINE if peak.line else OWN) * spectrum.motion[at]
        own |= not peak.line and share[at] > CONTRAST * usual[at]
        if own and not _harmonic(spectrum, peak.frequency):
            found.append(peak)
    return sorted(found, key=lambda peak: -peak.power)


def _harmonic(spectrum: Spectrum, frequency: float) -> bool:
    """Whether a frequency could be a multiple of the motion's own, as nonlinearity makes them."""
    base = float(spectrum.frequency[int(np.argmax(spectrum.motion))])
    if base <= 0.0 or frequency > HARMONICS * base:
        return False
    return abs(frequency - base * round(frequency / base)) < spectrum.resolution


def _neighbourhood(density: Array, wide: int) -> Array:
    """The median over `wide` bins on each side; every PADDING-th stands for its neighbours."""
    around = median_filter(density[::PADDING], size=2 * (wide // PADDING) + 1, mode="nearest")
    index = np.arange(len(density))
    smooth: Array = np.interp(index, index[::PADDING], around)
    return smooth


def _peak(spectrum: Spectrum, density: Array, around: Array, at: int, contrast: float) -> Peak:
    frequency, step = spectrum.frequency, spectrum.step
    half = 0.5 * density[at]
    above = density > half
    first, last = at, at
    while first > 0 and above[first - 1]:
        first -= 1
    while last < len(density) - 1 and above[last + 1]:
        last += 1
    # A parabola through the logarithms finds a line between two bins.
    left, top, right = np.log(density[[at - 1, at, min(at + 1, len(density) - 1)]])
    bend = left - 2.0 * top + right
    centre = frequency[at] + (0.5 * step * (left - right) / bend if bend < 0.0 else 0.0)
    width = float(frequency[last] - frequency[first])
    line = width < 2.6 * HALF_POWER * spectrum.resolution
    lobe = max(last - first, int(spectrum.resolution / step))
    inside = slice(max(0, at - lobe), at + lobe + 1)
    power = float(np.sum(np.maximum(density[inside] - around[inside], 0.0))) * step
    if line:
        half_width = 0.5 * spectrum.resolution
        low, high = max(0.0, float(centre) - half_width), float(centre) + half_width
    else:
        low, high = float(frequency[first]), float(frequency[last])
    return Peak(float(centre), low, high, power, contrast, line)


def _broad(spectrum: Spectrum, noise: float, total: float) -> list[Band]:
    """The band with MOST of the gap, where the voltage has far less of its own power."""
    edges = [spectrum.resolution]
    while edges[-1] < spectrum.frequency[-1]:
        edges.append(edges[-1] * 2.0 ** (1.0 / PER_OCTAVE))
    if len(edges) < 4:
        return []
    bin_of = np.searchsorted(edges, spectrum.frequency) - 1
    inside = (bin_of >= 0) & (bin_of < len(edges) - 1)
    floor = 2.0 * noise**2 * spectrum.period
    excess = (spectrum.error - floor)[inside] * spectrum.step
    gap = np.bincount(bin_of[inside], weights=excess, minlength=len(edges) - 1)
    drive = spectrum.voltage[inside] / max(float(np.sum(spectrum.voltage)), 1e-300)
    volts = np.bincount(bin_of[inside], weights=drive, minlength=len(edges) - 1)
    best: tuple[float, int, int] | None = None
    for first in range(len(gap)):
        for last in range(first + 1, len(gap) + 1):
            share = float(gap[first:last].sum()) / total
            narrow = share / max(float(volts[first:last].sum()), (last - first) / len(gap))
            if share >= MOST and narrow >= NARROW and (best is None or narrow > best[0]):
                best = narrow, first, last
    if best is None:
        return []
    narrow, first, last = best
    share = min(1.0, float(gap[first:last].sum()) / total)
    high = min(edges[last], float(spectrum.frequency[-1]))
    return [Band(Range("frequency_Hz", edges[first], high, share), narrow)]


def slow_share(residuals: Sequence[Residual], noise: float) -> float:
    """How much of the gap is slower than SLOW and no function of the voltage, 0 .. 1.

    A recording counts where a slow course leaves much less than a loop over the voltage. The course
    is fitted on all readings that count, as a block is shorter than what is looked for, and bends
    less often than the voltage turns: any loop would pass for one that bends as often.
    """
    gap = gap_energy(residuals, noise)
    taken = 0.0
    for residual in residuals:
        if SLOW * residual.recording.duration < 1.0:
            continue  # whatever it is, it is faster
        size = max(1, len(residual.error) // 1000)
        means = residual.means(size)
        count, seen = len(means), np.isfinite(means)
        means = means[seen]
        drive = _branches(residual.recording.voltage)[: count * size : size][seen]
        bends = min(
            round(2.0 * SLOW * residual.recording.duration), residual.turning.turns // 2, count // 4
        )
        place = (np.flatnonzero(seen) + 0.5) * np.pi / count
        courses = np.cos(np.outer(place, np.arange(1, max(2, bends) + 1)))
        alone = _left(means, courses)
        driven = _left(means, drive)
        found = float(np.sum((means - means.mean()) ** 2)) - alone
        if alone < BETTER * driven:
            judged = residual.counted.sum() / residual.recording.counting.sum()
            taken += found * size * float(judged)
    return float(np.clip(taken / gap, 0.0, 1.0)) if gap > 0.0 else 0.0


def _branches(voltage: Array) -> Array:
    """Powers of the voltage, and loops that close at its extremes, shape (n, 5)."""
    middle, half = float(np.mean(voltage)), float(np.ptp(voltage)) / 2.0 or 1.0
    v = (voltage - middle) / half
    direction = np.sign(np.diff(v, prepend=v[0]))
    index = np.maximum.accumulate(np.where(direction != 0.0, np.arange(len(v)), 0))
    branch = direction[index]
    return np.stack([v, v**2, v**3, branch * (1.0 - v**2), branch * (v - v**3)], axis=1)


def _left(signal: Array, columns: Array) -> float:
    matrix = np.hstack([np.ones((len(signal), 1)), columns])
    rest = signal - matrix @ np.linalg.lstsq(matrix, signal, rcond=None)[0]
    return float(rest @ rest)
