"""Which tick it is: by the clock, or by the stamp of a sample."""

from __future__ import annotations

import math

from microgripper_control.nodes.new_time import NewTime

LONGEST_PAUSE = 1.0  # s, at least 10 samples: what went on in a longer one nobody knows


def longest_pause(rate: float) -> float:
    """Of a clock of `rate`, Hz, s: a stamp further ahead is not believed by itself."""
    return max(LONGEST_PAUSE, 10.0 / rate)


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

    So a sample that was lost does not shift those after it. A stamp before the newest, or far ahead
    of it, is one that was overtaken, or a wild one: it is not `believed` until several in a row
    agree. Then time goes on from there; behind what was before it is a new beginning, counted in
    `restarts`. `disbelieved` counts the others.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._pause = longest_pause(rate)
        self._other = NewTime(self._pause)
        self._first: int | None = None  # ns, of sample 0
        self._stamp = self._before = 0  # ns, of the newest that is believed, and of the one before
        self.newest = -1
        self.believed = False  # whether the last stamp was
        self.restarts = self.disbelieved = 0

    def of(self, stamp: int) -> int:
        """The number of the sample with this stamp, ns; the newest one's if it is not believed."""
        if self._first is None:
            self._first = self._stamp = self._before = stamp
        follows = 0.0 <= (stamp - self._stamp) * 1e-9 <= self._pause
        # No clock to compare with: in lockstep time does not pass as it does here.
        self.believed = follows or self._other.agrees(stamp, -1e-9 * stamp)
        if not self.believed:
            self.disbelieved += 1
            return self.newest
        first_alone = self.newest == 0  # nobody had agreed with it
        # Where it lies behind the newest, but not the one before, that one was wild.
        if not follows and (stamp <= self._before or first_alone):
            self.restarts += 1
            self._first = self._other.first
        self._other.forget()
        self._before, self._stamp = min(self._stamp, stamp), stamp
        self.newest = round((stamp - self._first) * 1e-9 * self._rate)
        return self.newest
