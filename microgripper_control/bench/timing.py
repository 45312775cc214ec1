"""Times of several ways of doing the same, taken in turns.

A machine changes its pace from second to second, so a time by itself says little and the ratio of
two means little unless both were taken together. Here the contestants take turns: round after round
each runs once, and the ratio is the median of the rounds' ratios.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from microgripper_control.core.signals import Array

LEAST = 5e-3  # s: a call that is quicker is repeated within its turn until it takes as long
LONG = 2.0  # s: a call that takes as long is not tried out before
QUARTERS = (25.0, 50.0, 75.0)  # percentiles


class Spread(NamedTuple):
    """A median and the quartiles around it."""

    low: float
    median: float
    high: float

    @classmethod
    def of(cls, values: Array) -> Spread:
        """Of numbers, shape (n,)."""
        low, median, high = np.percentile(values, QUARTERS)
        return cls(float(low), float(median), float(high))

    @classmethod
    def single(cls, value: float) -> Spread:
        """Of what was measured once."""
        return cls(value, value, value)


class Contestant(NamedTuple):
    """A call and how many units of work (samples, messages) it does: times are per unit."""

    call: Callable[[], object]
    work: float = 1.0


@dataclass(frozen=True)
class Times:
    """Seconds per unit of work by the contestants' names, one number a round."""

    rounds: Mapping[str, Array]

    def of(self, name: str) -> Spread:
        """One contestant's time, s."""
        return Spread.of(self.rounds[name])

    def ratio(self, name: str, to: str) -> Spread:
        """How many times as long as `to` it takes, from the ratios of the rounds."""
        return Spread.of(self.rounds[name] / self.rounds[to])


def take_turns(contestants: Mapping[str, Contestant], rounds: int) -> Times:
    """Time the contestants; each has run once before, so that compilers and caches are warm."""
    counts = {name: _count(contestant.call) for name, contestant in contestants.items()}
    times: dict[str, list[float]] = {name: [] for name in contestants}
    for _ in range(rounds):
        for name, (call, work) in contestants.items():
            times[name].append(_seconds(call, counts[name]) / (counts[name] * work))
    return Times({name: np.array(values) for name, values in times.items()})


def _count(call: Callable[[], object]) -> int:
    """How often a call is to be repeated in a turn; the first call warms up."""
    if _seconds(call, 1) > LONG:
        return 1
    return max(1, round(LEAST / _seconds(call, 1)))


def _seconds(call: Callable[[], object], count: int) -> float:
    start = time.perf_counter()
    for _ in range(count):
        call()
    return time.perf_counter() - start
