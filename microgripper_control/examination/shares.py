"""Shares and medians with the intervals that so many cases allow."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

Z = 1.959963984540054  # of a two-sided 95 % interval


@dataclass(frozen=True)
class Share:
    """So many of so many; NaN where there are none."""

    right: int
    of: int

    @classmethod
    def among(cls, answers: Iterable[bool | None]) -> Share:
        """How many are true; None does not count."""
        counted = [answer for answer in answers if answer is not None]
        return cls(sum(counted), len(counted))

    @property
    def value(self) -> float:
        """The share, 0 .. 1."""
        return self.right / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of Wilson (1927)."""
        if not self.of:
            return math.nan, math.nan
        n, p = self.of, self.value
        middle = (p + Z**2 / (2.0 * n)) / (1.0 + Z**2 / n)
        half = Z / (1.0 + Z**2 / n) * math.sqrt(p * (1.0 - p) / n + Z**2 / (4.0 * n**2))
        low = 0.0 if self.right == 0 else middle - half
        high = 1.0 if self.right == n else middle + half
        return low, high


@dataclass(frozen=True)
class Middle:
    """The median of so many values, with its 95 % interval; NaN where there are none.

    Of fewer than 6 values there is no such interval: even from the least to the largest there are
    but 94 % (of 5).
    """

    value: float
    low: float
    high: float
    of: int

    @classmethod
    def among(cls, values: Sequence[float]) -> Middle:
        """Of some values; the interval is that of their order statistics."""
        count = len(values)
        if not count:
            return cls(math.nan, math.nan, math.nan, 0)
        ordered = np.sort(np.asarray(values, dtype=np.float64))
        place = int(binom.ppf(0.025, count, 0.5))  # of the ends, counted from either side
        low = high = math.nan
        if place:
            low, high = float(ordered[place - 1]), float(ordered[count - place])
        return cls(float(np.median(ordered)), low, high, count)
