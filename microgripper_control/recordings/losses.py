"""Counts what is missing from a stream, message by message as it comes."""

from __future__ import annotations

import struct
from collections import defaultdict
from statistics import median

LEAP = 10_000  # numbers: more than are kept, so that so many are not lost at once
MOST_DRIVERS = 100  # beyond it names that are new are not told apart: they would fill the memory
FIRST = 200  # intervals between stamps that tell the sample period
HEADER = struct.Struct("<4xiII")  # of a serialized JointState: s, ns, bytes of the frame's name
NAMES = struct.Struct("<II")  # behind that name: how many joints, bytes of the first one's name


class Sequence:
    """Messages of publishers that each number their own; one that is new begins anywhere.

    A number follows the largest below it that nothing has followed yet, but not by a LEAP.
    """

    def __init__(self) -> None:
        self.count = 0
        self.lost = 0
        self._lasts: set[int] = set()  # the last number of each publisher

    def note(self, number: int) -> None:
        """Count a message with its sequence number."""
        self.count += 1
        near = range(number - LEAP, number)
        last = max((last for last in self._lasts if last in near), default=None)
        if last is not None:
            self.lost += number - last - 1
            self._lasts.remove(last)
        self._lasts.add(number)


class JointStates:
    """Serialized `joint_states` as they come, those of each driver on a clock of its own.

    A driver is known by the first joint in its messages.
    """

    def __init__(self) -> None:
        self._drivers: defaultdict[bytes, StampedSamples] = defaultdict(StampedSamples)

    @property
    def missing(self) -> int:
        """How many ticks of their clocks had no sample."""
        return sum(samples.missing for samples in self._drivers.values())

    def note(self, message: bytes) -> None:
        """Count a message; one that is cut off is none."""
        try:
            seconds, nanoseconds, frame = HEADER.unpack_from(message)
            names = HEADER.size + frame + -frame % 4  # lengths are aligned
            count, length = NAMES.unpack_from(message, names)
        except struct.error:
            return
        first = names + NAMES.size
        driver = message[first : first + length] if count else b""
        if driver not in self._drivers and len(self._drivers) >= MOST_DRIVERS:
            driver = b""
        self._drivers[driver].note(seconds * 10**9 + nanoseconds)


class StampedSamples:
    """Samples of a uniform clock whose stamps have been seen, in order of receipt.

    A stamp that does not follow the one before is no gap: time that stands still or runs backwards
    is a new beginning.
    """

    def __init__(self) -> None:
        self.count = 0
        self._last = 0  # ns
        self._first: list[int] = []  # intervals, ns, until the period is known
        self._period = 0.0  # ns
        self._missing = 0

    @property
    def missing(self) -> int:
        """How many ticks of the clock had no sample."""
        if self._period or len(self._first) < 2:
            return self._missing
        period = float(median(self._first))
        return sum(_skipped(interval, period) for interval in self._first)

    def note(self, stamp: int) -> None:
        """Count a sample with its stamp, ns."""
        interval, self._last = stamp - self._last, stamp
        self.count += 1
        if self.count == 1 or interval <= 0:
            return
        if self._period:
            self._missing += _skipped(interval, self._period)
            return
        self._first.append(interval)
        if len(self._first) == FIRST:
            missing = self.missing
            self._period, self._missing = float(median(self._first)), missing


def _skipped(interval: int, period: float) -> int:
    return max(0, round(interval / period) - 1)
