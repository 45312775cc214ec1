"""At which rate a plant samples, as the stamps of its samples tell."""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from statistics import median

ENOUGH = 20  # samples
SAME = 0.2  # stamps jitter, and a slow machine misses ticks


class StampRate:
    """Compares the stamps of the newest samples with the `rate`, Hz, that they should come at."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._stamps: deque[int] = deque(maxlen=ENOUGH)  # ns

    def note(self, stamp: int) -> None:
        """Take the stamp of one more sample, ns."""
        self._stamps.append(stamp)

    @property
    def told(self) -> float:
        """The rate that they tell, Hz; the expected one before there are enough that agree."""
        if len(self._stamps) < ENOUGH:
            return self._rate
        between = median(later - earlier for earlier, later in pairwise(self._stamps))
        return 1e9 / between if between > 0 else self._rate

    @property
    def is_another(self) -> bool:
        """Whether they tell a rate that is none of jitter."""
        return abs(self._rate / self.told - 1.0) > SAME
