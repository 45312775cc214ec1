"""The highest rate that is kept up with, by bisection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Highest:
    """What was found: the highest `rate`, Hz, or one that it is `below`; and what was `tried`."""

    rate: float
    tried: tuple[float, ...]
    below: bool = False


def highest_rate(rates: Sequence[float], kept: Callable[[float], bool]) -> Highest:
    """Of some rates, Hz, rising; `kept` says whether one is kept up with.

    The lowest is asked first: where that is too high the others are.
    """
    holds, fails = 0, len(rates)
    tried = [rates[0]]
    if not kept(rates[0]):
        return Highest(rates[0], tuple(tried), below=True)
    while fails - holds > 1:
        middle = (holds + fails) // 2
        tried.append(rates[middle])
        if kept(rates[middle]):
            holds = middle
        else:
            fails = middle
    return Highest(rates[holds], tuple(sorted(tried)))
