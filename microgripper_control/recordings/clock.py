"""Samples with time stamps put on one uniform clock.

Stamps jitter, repeat and miss. Where the samples are the ticks of a uniform clock, up to a jitter
that does not matter or to the digits that the stamps are written with, they are taken as they are
and only missing ticks are filled in. So are those of a loop that waits a period after each, a
little more or less, and so wanders off: what was commanded at one tick is answered at the next,
however long that takes. Otherwise the signals are read off at equal intervals, which moves a held
voltage by up to one of them. What was done is said in the recording's warnings.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from microgripper_control.core.errors import MicrogripperError, one_line
from microgripper_control.core.recording import Recording, check_samples
from microgripper_control.core.signals import Array
from microgripper_control.recordings.samples import Samples

LATEST = 1e15  # s, thirty million years: what is beyond it is no time
LARGEST_JITTER = 0.02  # of the sample period, of 95 % of the stamps: below it they are uniform
LARGEST_STEP = 0.25  # of the sample period: if 95 % of the steps are as near to whole ones,
SWAY = 12  # samples within which it goes from one phase to another,
FARTHEST = 0.01  # and no sample is off by more of the recording, it is a clock that jitters
COARSEST_DIGIT = 0.35  # of the sample period: the last that stamps of a uniform clock may have
CLEARLY_LATE = 0.1  # of the sample period
MOST_REPEATED = 0.1  # of the stamps: beyond it they have too few digits
MOST_MISSING = 3.0  # of the samples that are there: beyond it gaps cannot be filled
MOST_OVERTAKEN = 0.05  # of the steps: beyond it, or by more than
OVERTAKEN = 5.0  # periods, time runs backwards
SHORT, MANY = 0.05, 0.25  # of a usual step; of all steps: so many so short ones are bursts


def on_uniform_clock(name: str, samples: Samples, warnings: tuple[str, ...] = ()) -> Recording:
    """Make a recording of stamped samples; `warnings` are added to those of this function.

    Raises MicrogripperError, with the index of the sample, on values that are not finite, on times
    that cannot be, on time that runs backwards and where more than three quarters of the ticks are
    missing.
    """
    check_samples(name, samples.voltage, samples.displacement, samples.setpoint)
    notes = list(warnings)
    samples = _increasing(name, samples, notes)
    period, known, timely = _positions(name, samples.time, notes)
    wanted = np.arange(int(known[-1] + 1e-6) + 1, dtype=float)
    recorded, read = None, None if timely.all() else np.isin(wanted, known[timely])
    if not np.array_equal(known, wanted):
        samples = samples.on(known, wanted)
        recorded = _recorded(known, wanted, notes)
    return Recording(
        name=name,
        sample_period=float(f"{period:.12g}"),  # 0.001 again, not 0.0010000000000000002
        voltage=samples.voltage,
        displacement=samples.displacement,
        setpoint=samples.setpoint,
        start=samples.origin + float(samples.time[0]),
        warnings=tuple(map(one_line, notes)),
        recorded=recorded,
        read=read,
    )


def _recorded(known: Array, wanted: Array, notes: list[str]) -> NDArray[np.bool_] | None:
    """Which ticks were recorded, not filled in; unequally spaced, those near a sample."""
    if np.array_equal(known, np.rint(known)):  # ticks of the clock, some of them missing
        return np.isin(wanted, known)
    after = np.searchsorted(known, wanted).clip(1, len(known) - 1)
    apart = np.minimum(np.abs(wanted - known[after - 1]), np.abs(known[after] - wanted))
    near: NDArray[np.bool_] = apart <= 1.0
    if near.all():
        return None
    notes.append(f"missing samples: {np.count_nonzero(~near)}; they do not count")
    return near


def _increasing(name: str, samples: Samples, notes: list[str]) -> Samples:
    """The samples in the order of their stamps, without those that were stored twice."""
    bad = np.flatnonzero(~(np.abs(samples.time) <= LATEST))  # or NaN
    if len(bad):
        value = samples.time[bad[0]]
        raise MicrogripperError(f"{name}: time is {value} at sample {bad[0]}; repair it")
    samples = _in_order(samples, notes)
    time = samples.time
    steps = np.diff(time)
    back = np.flatnonzero(steps < 0.0)
    if len(back):
        at = back[0] + 1
        raise MicrogripperError(
            f"{name}: time runs backwards at sample {at}, from {time[at - 1]:.9g} s to "
            f"{time[at]:.9g} s; cut the recording there"
        )
    repeated = int(np.count_nonzero(steps == 0.0))
    if not repeated:
        return samples
    if repeated > MOST_REPEATED * len(time):
        raise MicrogripperError(
            f"{name}: {repeated} of {len(time)} time stamps repeat the one before; "
            "write time with more digits"
        )
    # Samples of one stamp that differ were taken in a stall, and stamped when it was over.
    twice = np.append(False, steps == 0.0)
    for signal in (samples.voltage, samples.displacement):
        if signal is not None:
            twice[1:] &= np.diff(signal) == 0.0
    if not twice.any():
        return samples
    notes.append(f"repeated samples: {np.count_nonzero(twice)}; they were dropped")
    samples = samples.where(~twice)
    check_samples(name, samples.voltage, samples.displacement, samples.setpoint)
    return samples


def _in_order(samples: Samples, notes: list[str]) -> Samples:
    """The samples sorted by their stamps where a few were overtaken by the next few."""
    steps = np.diff(samples.time)
    late, ahead = np.count_nonzero(steps < 0.0), steps[steps > 0.0]
    if not late or not len(ahead) or late > MOST_OVERTAKEN * len(steps):
        return samples
    if np.min(steps) < -OVERTAKEN * float(np.median(ahead)):
        return samples
    notes.append(f"overtaken by the next: {late} samples; they were put in the order of stamps")
    return samples.where(np.argsort(samples.time, kind="stable"))


def _positions(name: str, time: Array, notes: list[str]) -> tuple[float, Array, NDArray[np.bool_]]:
    """The sample period, s, where the samples lie, in periods from the first, and which in time.

    Whole numbers if they are the ticks of a uniform clock, some of which may be missing.
    """
    clock = _Clock.through(time, np.arange(len(time), dtype=float))
    if not clock.fits(time):
        clock = _Clock.through(time, _ticks_with_gaps(time))
    steps = np.diff(time)
    uniform = clock.fits(time)
    timely = np.ones(len(time), bool)
    period, known, timely = (clock.period, clock.ticks, timely) if uniform else _swaying(time)
    ticked = uniform or np.array_equal(known, np.rint(known))
    missing = int(known[-1] + 1e-6) + 1 - len(known)
    too_few = missing > MOST_MISSING * len(known)
    if too_few or not uniform:
        _refuse_bursts(name, steps)
    longest = int(np.argmax(steps))
    gap = f"the longest gap is {steps[longest]:.6g} s after sample {longest}"
    if too_few:
        raise MicrogripperError(
            f"{name}: of {len(known) + missing} samples at {period:.6g} s only {len(known)} are "
            f"there, {gap}; cut the recording there"
        )
    if uniform:
        notes.extend(clock.late_stamps())
    else:
        resampled = f"resampled at {period:.6g} s, voltage held, displacement interpolated"
        done = f"taken as ticks of a clock of {period:.6g} s" if ticked else resampled
        spread = np.std(steps) / period
        notes.append(f"samples are unequally spaced ({spread:.1%} of the period rms): {done}")
    if ticked and missing:
        notes.append(f"missing samples: {missing}, {gap}; voltage held, displacement interpolated")
    if untimely := np.count_nonzero(~timely):
        notes.append(
            f"untimely samples: {untimely} follow the one before by {LARGEST_STEP:g} of a period "
            "more or less than whole ones; their readings do not count"
        )
    return period, known, timely


def _swaying(time: Array) -> tuple[float, Array, NDArray[np.bool_]]:
    """The sample period, s, where samples lie, in periods from the first, and which in time.

    On the ticks of a clock that sways if nearly all steps are near whole periods, or else wherever
    their time has them. What is on its way is elsewhere after another step than the clock has it.
    """
    steps = np.diff(time)
    ticks = _ticks_with_gaps(time, SWAY)
    duration = float(time[-1] - time[0])
    period = duration / float(ticks[-1])
    off = np.abs(steps / period - np.diff(ticks))
    wandered = np.ptp(time - time[0] - period * ticks)
    if np.quantile(off, 0.95) <= LARGEST_STEP and wandered <= FARTHEST * duration:
        return period, ticks, np.append(True, off <= LARGEST_STEP)
    typical = _typical(steps)
    return typical, (time - time[0]) / typical, np.ones(len(time), bool)


def _refuse_bursts(name: str, steps: Array) -> None:
    """Raise MicrogripperError where stamps nearly coincide so often that they show no clock."""
    long = float(np.quantile(steps, 0.9))
    short = int(np.count_nonzero(steps < SHORT * long))
    if short > MANY * len(steps):
        raise MicrogripperError(
            f"{name}: the time stamps come in bursts: {short} of {len(steps)} steps are shorter "
            f"than {SHORT * long:.2g} s, some take {long:.2g} s; stamp a sample when it is taken"
        )


@dataclass(frozen=True)
class _Clock:
    """A uniform clock with a period in s.

    Sample i is its tick `ticks[i]`, counted from 0, and stamped `jitter[i]` periods late.
    """

    period: float
    ticks: Array
    jitter: Array

    @classmethod
    def through(cls, time: Array, ticks: Array) -> _Clock:
        """The clock that fits best where the stamps are not out of all order."""
        k, t = ticks, time
        for _ in range(3):
            centred = k - k.mean()
            period = float(centred @ (t - t.mean()) / (centred @ centred))
            jitter = time / period
            jitter -= ticks
            jitter -= np.median(jitter)
            near = np.abs(jitter) < 0.5
            count = np.count_nonzero(near)
            if count == len(k) or count < 0.5 * len(time):
                break
            k, t = ticks[near], time[near]
        return cls(period, ticks, jitter)

    @cached_property
    def off(self) -> Array:
        """How far the stamps are off the ticks, in periods."""
        return np.abs(self.jitter)

    @cached_property
    def even(self) -> bool:
        """Whether nearly all stamps are near their ticks."""
        near = np.count_nonzero(self.off <= LARGEST_JITTER)  # a quantile would copy and sort
        return bool(near >= 0.95 * len(self.off))

    def fits(self, time: Array) -> bool:
        """Whether the stamps are those ticks, up to what does not matter or was rounded off."""
        # A program can stamp a sample late, never early, and catches up in the end: what looks
        # otherwise is a missing sample.
        if np.min(self.jitter) < -0.75 or self.jitter[-1] > 0.75:
            return False
        if self.even:
            return True
        digit = _last_digit(time)
        return bool(
            digit < COARSEST_DIGIT * self.period and np.max(self.off) * self.period <= 0.55 * digit
        )

    def late_stamps(self) -> list[str]:
        """A note on stamps that are off by more than rounding and jitter."""
        count = np.count_nonzero(self.off > CLEARLY_LATE)
        if not count or not self.even:
            return []
        latest = np.max(self.off) * self.period
        return [f"late stamps: {count}, by up to {latest:.6g} s; taken as on time"]


def _last_digit(time: Array) -> float:
    """The power of ten, s, of which all stamps are multiples; at least a nanosecond."""
    for digits in range(9):
        scaled = (time - time[0]) * 10.0**digits
        if np.max(np.abs(scaled - np.rint(scaled))) < 1e-3:
            return 10.0**-digits
    return 1e-9


def _typical(steps: Array) -> float:
    """The mean of the steps without gaps among them."""
    middle = np.partition(steps, len(steps) // 2)[len(steps) // 2]  # one of them, not between two
    return float(np.mean(steps[np.abs(steps - middle) <= 0.5 * middle]))


def _ticks_with_gaps(time: Array, sway: int = 0) -> Array:
    """The ticks, from 0, of a clock that fits most of the stamps, where samples are missing.

    It may sway from one phase to another within some samples; with 0 it does not.
    """
    period = _typical(np.diff(time))
    position = (time - time[0]) / period
    phasor = np.exp(2j * np.pi * position)
    mean = uniform_filter1d(phasor, sway, mode="nearest") if sway else np.mean(phasor)
    phase = np.unwrap(np.atleast_1d(np.angle(mean))) / (2.0 * np.pi)
    ticks = np.rint(position - phase)
    # A stamp can be late, and then shares its tick with a later sample: it belongs to the last tick
    # that leaves one to each of those that follow.
    order = np.arange(float(len(time)))
    ticks = np.minimum.accumulate((ticks - order)[::-1])[::-1] + order
    return np.asarray(ticks - ticks[0])
