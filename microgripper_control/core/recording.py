"""A recording: voltage and displacement of a rig on one uniform clock, checked at birth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.runs import runs
from microgripper_control.core.signals import Array

SHORTEST = 10  # samples
STEADY = 0.01  # of the voltage's span: a smaller change over a gap leaves no doubt about its moment
UNSETTLED = 0.05  # s: how long a rig may still answer to a voltage that is not known,
UNSETTLED_SAMPLES = 5  # at the least
MOST_UNSETTLED = 0.2  # of all samples: more of them do not go uncounted for that

SAME_PERIOD = 1e-4  # of it: stamps that jitter give each recording of one clock another period

Mask = NDArray[np.bool_]


def same_period(one: float, other: float) -> bool:
    """Whether two sample periods, s, are those of the same clock."""
    return math.isclose(one, other, rel_tol=SAME_PERIOD)


def check_samples(
    name: str, voltage: Array, displacement: Array | None, setpoint: Array | None
) -> None:
    """Raise MicrogripperError naming the recording where samples are too few or not finite.

    A setpoint may be NaN: before the first one arrived there was none.
    """
    if len(voltage) < SHORTEST:
        raise MicrogripperError(f"{name}: {len(voltage)} samples; at least {SHORTEST} are needed")
    signals = {"voltage": voltage, "displacement": displacement, "setpoint": setpoint}
    for label, samples in signals.items():
        if samples is None:
            continue
        if samples.shape != voltage.shape:
            raise MicrogripperError(
                f"{name}: {label} has {len(samples)} samples, not {len(voltage)} as voltage"
            )
        bad = np.flatnonzero(~np.isfinite(samples))
        if len(bad) and label != "setpoint":
            raise MicrogripperError(
                f"{name}: {label} is {samples[bad[0]]} at sample {bad[0]} "
                f"({len(bad)} such); remove or interpolate it"
            )


@dataclass(frozen=True)
class Recording:
    """Samples k = 0 .. n-1 at `start` + k `sample_period`.

    `voltage[k]` (V) is applied from that instant on, `displacement[k]` (m) is read at it;
    `displacement` and `setpoint` (m) are None where they were not recorded. `warnings` says what
    was mended on reading. `recorded` (bool, shape (n,), None for all) says which samples are no
    fillings, `read` which of them have a reading that counts.
    `reading_age` is how old the first reading is where the sensor converts on a clock of its own;
    `part` says that it is a stretch of what was recorded, `skipped` how long after the beginning of
    that it begins. Raises MicrogripperError naming the recording on bad samples.
    """

    name: str
    sample_period: float  # s
    voltage: Array
    displacement: Array | None = None
    setpoint: Array | None = None
    start: float = 0.0  # s
    warnings: tuple[str, ...] = ()
    recorded: Mask | None = None
    read: Mask | None = None
    reading_age: float = 0.0  # s
    part: bool = False
    skipped: float = 0.0  # s

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sample_period) and self.sample_period > 0.0):
            raise MicrogripperError(f"{self.name}: sample period {self.sample_period} s")
        check_samples(self.name, self.voltage, self.displacement, self.setpoint)
        for samples in (self.voltage, self.displacement, self.setpoint):
            if samples is not None:
                samples.setflags(write=False)

    def __len__(self) -> int:
        return len(self.voltage)

    @property
    def measured(self) -> Array:
        """The displacement, m; MicrogripperError if it was not recorded."""
        if self.displacement is None:
            raise MicrogripperError(f"{self.name}: has no displacement; record it, or map it")
        return self.displacement

    def stretch(self, part: slice) -> Recording:
        """Some of its samples, in a row, as a recording of its own, without the setpoint."""
        before = part.start * self.sample_period
        return replace(
            self,
            voltage=self.voltage[part],
            displacement=self.measured[part],
            setpoint=None,
            start=self.start + before,
            recorded=None if self.recorded is None else self.recorded[part],
            read=None if self.read is None else self.read[part],
            reading_age=self.reading_age + before,
            part=True,
            skipped=self.skipped + before,
        )

    @property
    def present(self) -> Mask:
        """The samples that were recorded, not filled in, shape (n,)."""
        return np.ones(len(self), bool) if self.recorded is None else self.recorded

    @property
    def counting(self) -> Mask:
        """The samples that were recorded with a reading that counts, shape (n,)."""
        return self.present if self.read is None else self.present & self.read

    @cached_property
    def explained(self) -> Mask:
        """Those that count and do not come soon after a voltage that is not known, shape (n,).

        A voltage that changed while nothing was recorded did so at an unknown moment.
        """
        counted: Mask = self.counting.copy()
        gaps = [gap for gap in runs(~self.present) if gap.start > 0 and gap.stop < len(self)]
        change = [abs(self.voltage[gap.stop] - self.voltage[gap.start - 1]) for gap in gaps]
        smallest = STEADY * np.ptp(self.voltage)
        unknown = [gap.stop for gap, by in zip(gaps, change, strict=True) if by > smallest]
        unsettled = self.unsettled(max(1, len(unknown)))
        for first in unknown:
            counted[first : first + unsettled] = False
        counted.setflags(write=False)
        return counted

    def unsettled(self, gaps: int = 1) -> int:
        """How many samples after each of some gaps answer to what happened in it."""
        samples = max(UNSETTLED_SAMPLES, round(UNSETTLED / self.sample_period))
        return min(samples, int(MOST_UNSETTLED * len(self) / gaps))

    @property
    def time(self) -> Array:
        """Sampling instants, s, shape (n,)."""
        return self.start + self.elapsed

    @property
    def elapsed(self) -> Array:
        """Since the first sample, s, shape (n,)."""
        return self.sample_period * np.arange(len(self), dtype=np.float64)

    @property
    def duration(self) -> float:
        """From the first sample to the last, s."""
        return self.sample_period * (len(self) - 1)


def refuse_twice(recordings: Sequence[Recording]) -> None:
    """Raise MicrogripperError where two recordings are one: it would count twice."""
    for i, one in enumerate(recordings):
        for other in recordings[:i]:
            if np.array_equal(one.voltage, other.voltage) and np.array_equal(
                one.measured, other.measured
            ):
                raise MicrogripperError(
                    f"{one.name}: has the same samples as {other.name}; give it once"
                )
