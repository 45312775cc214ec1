"""Which tick it is: by the clock, or by the stamp of a sample."""

from __future__ import annotations

import math


class Pace:
    """Tick k is due at `start` + k `period` (s, of any clock that does not jump).

    None is bunched up; those that were slept through are told.
    """

    def __init__(self, period: float, start: float) -> None:
        self.period = period
        self.start = start
        self.tick = -1  # the newest that was due

    def due(self, now: float) -> int:
        """How many ticks have become due since the last call; all but the newest were missed."""
        newest = math.floor((now - self.start) / self.period)
        count = max(0, newest - self.tick)
        self.tick += count
        return count

    def wait(self, now: float) -> float:
        """Time until the next tick is due, s; 0 if it is overdue."""
        return max(0.0, self.start + (self.tick + 1) * self.period - now)


class SampleNumber:
    """Numbers the samples of a clock of `rate` (Hz) by their stamps, from 0 on.

    So a sample that was lost does not shift those after it. Time that runs backwards is a new
    beginning, counted in `restarts`.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._first: int | None = None  # ns
        self.newest = -1
        self.restarts = 0

    def of(self, stamp: int) -> int:
        """The number of the sample with this stamp, ns."""
        if self._first is None:
            self._first = stamp
        number = round((stamp - self._first) * 1e-9 * self._rate)
        if number < self.newest:
            self.restarts += 1
            self._first, number = stamp, 0
        self.newest = number
        return number
