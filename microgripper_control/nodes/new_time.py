"""When stamps that contradict the time so far are believed: once several in a row agree."""

from __future__ import annotations

import math

AGREE = 5  # samples in a row that make a new time


class NewTime:
    """Stamps in a row that agree with one another, but not with the time so far.

    Each comes after the one before, and its offset from a clock is the same up to `limit`, s.
    `first` is the stamp, ns, that the others follow.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._count = 0
        self._stamp, self._offset = 0, math.nan
        self.first = 0

    def forget(self) -> None:
        """Begin again: a stamp came that agrees with the time so far."""
        self._count = 0

    def agrees(self, stamp: int, offset: float) -> bool:
        """Whether enough agree with a stamp, ns, and its offset, s, itself included."""
        follows = stamp > self._stamp and abs(offset - self._offset) <= self._limit
        if follows and self._count:
            self._count += 1
        else:
            self._count, self.first = 1, stamp
        self._stamp, self._offset = stamp, offset
        return self._count >= AGREE
