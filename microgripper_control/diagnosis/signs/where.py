"""Where the gap lies: along which axis the unexplained error is concentrated, and in what range.

Three kinds of places are looked for. A range of an axis that holds much more of the error's power
than of the samples, found on every second piece of the recordings and confirmed on the others. A
bend: a position or a voltage beyond which the residual takes another slope (see `onset`). And a
part of the spectrum where the voltage has little (see `bands`). What could be chance is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import REAL, Residual, gap_energy, gap_power
from microgripper_control.diagnosis.findings import Range
from microgripper_control.diagnosis.signs.bands import bands
from microgripper_control.diagnosis.signs.holds import growth_in_holds
from microgripper_control.diagnosis.signs.onset import NoOnset, Pick, find_onset

BINS = 24
MOST = 0.6  # of the gap: what a reported range holds at least
CONCENTRATION = 2.0  # share of the gap over share of the samples, at least
ONE_WAY = 1.6  # the same where a direction can have no more than twice its share
SAME = 1e-6  # of the range of the values: what lies closer together is one value
RAREST = (0.98, 0.99, 0.997)  # quantiles that finer bins begin at where the largest values matter
FEWEST = 1000  # samples
PIECES = 40  # that the samples are cut into; every second one confirms,
GOLDEN = 0.618  # and they are uneven: as many as cycles, or half cycles, would always show the same
RECENT = 0.01  # s: how far back a fast change of the voltage counts
AFTER = 0.1  # s after a step: what is slower than this is no swinging any more
SLIPPED = 0.6  # of the slow error's squares: what one jump explains at least
ABRUPT = 0.5  # of what a smooth course leaves: what the jump leaves at most
GROWTH = 0.3  # of what changes during the holds: what a logarithm explains at least,
CERTAIN = 4.0  # and how many times its own uncertainty it is
# As how concentrated a gap counts that a law explains, for each share that it explains: a law tells
# more than where the power went.
BENDS, GROWS, JUMPS = 10.0, 5.0, 4.0


@dataclass(frozen=True)
class _Found:
    """A range and how concentrated the gap is in it: share of the gap over that of the samples."""

    place: Range
    concentration: float


def locate(residuals: Sequence[Residual], noise: float) -> list[Range]:
    """The ranges that hold most of the gap or begin at a bend, the most concentrated first.

    `noise` is the standard deviation of the white noise, m. `low` and `high` are in the axis's own
    unit; of `direction` both are -1 or 1. Empty where there is no gap, or none of it anywhere in
    particular.
    """
    total = gap_power(residuals, noise)
    found = [_Found(band.place, band.concentration) for band in bands(residuals, noise)]
    if total > REAL * noise**2:
        found += _bends(residuals, noise)
        taken = {one.place.axis for one in found}
        if not taken & {"displacement_m", "voltage_V"}:
            found += _concentrated("displacement_m", _position, residuals, noise)
            found += _concentrated("voltage_V", _voltage, residuals, noise)
        found += _concentrated("rate_V_per_s", _recent_rate, residuals, noise, upwards=True)
        found += _one_way(residuals, noise)
        found += _growing(residuals, noise) or _concentrated(
            "hold_time_s", lambda residual: residual.hold_time, residuals, noise
        )
        found += _slipped(residuals, noise)
    return [one.place for one in sorted(found, key=lambda one: -one.concentration)]


def _position(residual: Residual) -> Array:
    return residual.position


def _voltage(residual: Residual) -> Array:
    return residual.recording.voltage


def _recent_rate(residual: Residual) -> Array:
    return recent_rate(residual.recording)


def recent_rate(recording: Recording) -> Array:
    """The fastest change of the voltage during the last RECENT seconds, V/s, shape (n,).

    What cannot follow a fast change is late when the change is over.
    """
    rate = np.abs(np.diff(recording.voltage, prepend=recording.voltage[0]))
    reach = max(1, round(RECENT / recording.sample_period))
    padded = np.concatenate([np.zeros(reach), rate / recording.sample_period])
    windows = np.lib.stride_tricks.sliding_window_view(padded, reach + 1)
    fastest: Array = windows.max(axis=1)
    return fastest


def _direction(residual: Residual) -> Array:
    change = np.diff(residual.recording.voltage, prepend=residual.recording.voltage[0])
    return np.where(residual.moves, np.sign(change), np.nan)


def _concentrated(
    axis: str, pick: Pick, residuals: Sequence[Residual], noise: float, upwards: bool = False
) -> list[_Found]:
    """The range that holds most of the gap in the smallest share of the samples.

    `upwards`: it must reach to the largest value.
    """
    values, power = _powers(pick, residuals, noise)
    if len(values) < FEWEST or np.ptp(values) == 0.0:
        return []
    values, edges = _binned(values, upwards)
    best = _confirmed(values, power, edges, CONCENTRATION, upwards)
    if best is None:
        return []
    run, share, concentration = best
    low, high = float(edges[run.start]), float(edges[run.stop])
    found = _Found(Range(axis, low, high, share), concentration)
    return _of_all(found, float(np.sum(power)), residuals, noise)


def _one_way(residuals: Sequence[Residual], noise: float) -> list[_Found]:
    """Whether most of the gap lies on rising or on falling voltage."""
    values, power = _powers(_direction, residuals, noise)
    if len(values) < FEWEST or np.ptp(values) == 0.0:
        return []
    best = _confirmed(values, power, np.array([-1.5, 0.0, 1.5]), ONE_WAY)
    if best is None:
        return []
    run, share, concentration = best
    way = -1.0 if run.start == 0 else 1.0
    found = _Found(Range("direction", way, way, share), concentration)
    return _of_all(found, float(np.sum(power)), residuals, noise)


def _of_all(
    found: _Found, power: float, residuals: Sequence[Residual], noise: float
) -> list[_Found]:
    """A range of samples that hold so much, m^2, of the gap, as one of all: with a share of that.

    None where it then holds too little: a gap at rest lies on no direction.
    """
    part = min(1.0, power / gap_energy(residuals, noise))
    share = part * found.place.share_of_gap
    if share < MOST:
        return []
    return [_Found(replace(found.place, share_of_gap=share), part * found.concentration)]


def _powers(pick: Pick, residuals: Sequence[Residual], noise: float) -> tuple[Array, Array]:
    """Of the samples where an axis has a value: that, and the error's power above the noise's."""
    values = np.concatenate([pick(residual)[residual.counted] for residual in residuals])
    errors = np.concatenate([residual.error[residual.counted] for residual in residuals])
    known = np.isfinite(values)
    return values[known], errors[known] ** 2 - noise**2


def _confirmed(
    values: Array, power: Array, edges: Array, least: float, upwards: bool = False
) -> tuple[slice, float, float] | None:
    """The best run of bins, its share of the gap, and how concentrated the gap is in it.

    Looked for in every second piece and judged on the others, and the other way round: the best of
    many ranges is always good where it was found.
    """
    count = len(edges) - 1
    if count < 2 or np.sum(power) <= 0.0:
        return None
    bin_of = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, count - 1)
    ends = np.sort(GOLDEN * np.arange(1, PIECES) % 1.0) * len(values)
    piece = np.searchsorted(ends, np.arange(len(values)), side="right") % 2
    shares, sizes = np.empty((2, count)), np.empty((2, count))
    for half in (0, 1):
        of_half = piece == half
        gap = np.bincount(bin_of[of_half], weights=power[of_half], minlength=count)
        if gap.sum() <= 0.0:
            return None
        shares[half] = gap / gap.sum()
        sizes[half] = np.bincount(bin_of[of_half], minlength=count) / np.count_nonzero(of_half)
    for half in (0, 1):
        run = _best_run(shares[half], sizes[half], upwards, least)
        if run is None or not _holds(shares[1 - half][run], sizes[1 - half][run], least):
            return None
    share, size = shares.mean(axis=0), sizes.mean(axis=0)
    run = _best_run(share, size, upwards, least)
    if run is None:
        return None
    held = float(share[run].sum())
    return run, min(1.0, held), held / float(size[run].sum())


def _binned(values: Array, upwards: bool) -> tuple[Array, Array]:
    """The values without rounding errors, and the edges of bins that hold about as many each.

    Where many share the largest value (a triangle has few rates) it has a bin to itself.
    """
    same = SAME * float(np.ptp(values))
    values = same * np.rint(values / same)
    parts = np.linspace(0.0, 1.0, BINS + 1)
    if upwards:
        parts = np.concatenate([parts, RAREST])
    largest = float(np.max(values))
    edges = np.unique(np.quantile(values, parts))
    shared = np.quantile(values, 1.0 - 1.0 / BINS) == largest
    return values, np.append(edges, largest) if shared else edges


def _best_run(share: Array, size: Array, upwards: bool, least: float) -> slice | None:
    """The run of bins with MOST of the gap and the fewest samples for it, if few enough."""
    best: tuple[float, slice] | None = None
    for first in range(len(share)):
        for last in range(first + 1, len(share) + 1):
            run = slice(first, last)
            if (upwards and last < len(share)) or not _holds(share[run], size[run], least):
                continue
            ratio = float(share[run].sum() / size[run].sum())
            if best is None or ratio > best[0]:
                best = ratio, run
    return None if best is None else best[1]


def _holds(share: Array, size: Array, least: float) -> bool:
    held, samples = float(share.sum()), float(size.sum())
    return held >= MOST and samples > 0.0 and held >= least * samples


def _bends(residuals: Sequence[Residual], noise: float) -> list[_Found]:
    """Beyond which position, and which voltage, the residual takes another slope."""
    found = []
    picks: tuple[tuple[str, Pick], ...] = (("displacement_m", _position), ("voltage_V", _voltage))
    for axis, pick in picks:
        onset = find_onset(residuals, pick, noise)
        if isinstance(onset, NoOnset):
            continue
        values, power = _powers(pick, residuals, noise)
        inside = (values >= onset.low) & (values <= onset.high)
        share = float(np.clip(np.sum(power[inside]) / np.sum(power), 0.0, 1.0))
        place = Range(axis, onset.low, onset.high, share, bend=onset.place)
        found.append(_Found(place, BENDS * onset.explained))
    return found


def _growing(residuals: Sequence[Residual], noise: float) -> list[_Found]:
    """Whether the error grows with the logarithm of the time since a step, its way or against."""
    growth = growth_in_holds(residuals, AFTER)
    if growth is None or growth.explained < GROWTH or growth.certainty < CERTAIN:
        return []
    values = np.concatenate([residual.hold_time[residual.counted] for residual in residuals])
    errors = np.concatenate([residual.error[residual.counted] for residual in residuals])
    power = errors**2 - noise**2
    inside = (values >= AFTER) & (values <= growth.longest)
    share = float(np.clip(np.sum(power[inside]) / np.sum(power), 0.0, 1.0))
    place = Range("hold_time_s", AFTER, growth.longest, share)
    return [_Found(place, GROWS * growth.explained)]


def _slipped(residuals: Sequence[Residual], noise: float) -> list[_Found]:
    """From when on the error stands elsewhere, if it has jumped once and for all."""
    found = []
    total = gap_energy(residuals, noise)
    for residual in residuals:
        size = max(1, len(residual.error) // 400)
        means = residual.means(size)
        seen = np.flatnonzero(np.isfinite(means))
        jump = _jump(means[seen] - means[seen].mean())
        if jump is None:
            continue
        time = residual.recording.skipped + residual.recording.elapsed
        low, high = float(time[seen[jump] * size]), float(time[-1])
        inside = residual.counted & (time >= low)
        power = residual.error[inside] ** 2 - noise**2
        share = float(np.clip(np.sum(power) / total, 0.0, 1.0))
        name = residual.recording.name if len(residuals) > 1 else ""
        found.append(_Found(Range("time_s", low, high, share, recording=name), JUMPS))
    return found


def _jump(error: Array) -> int | None:
    """The index from which on the mean of a centred series is another, if that is what it is."""
    count = len(error)
    if count < 40:
        return None
    index = np.arange(1, count)
    sums = np.cumsum(error)[:-1]
    taken = sums**2 * count / (index * (count - index))  # squares that a jump there explains
    edge = count // 20
    best = edge + int(np.argmax(taken[edge : count - edge]))
    squares = float(error @ error)
    left = squares - float(taken[best])
    time = np.linspace(-1.0, 1.0, count)
    smooth = error - np.polynomial.Polynomial.fit(time, error, 5)(time)
    if squares - left < SLIPPED * squares or left > ABRUPT * float(smooth @ smooth):
        return None
    return best + 1
