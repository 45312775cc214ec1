"""The h that a recording starts with: a search in one variable.

It is looked for over all of its range, and then ever closer around the best look.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from microgripper_control.core.signals import Array

LOOKS = 7  # all over the range,
CLOSER = 12  # looks between the best of them, at most:
BESIDE = 0.02  # of the bound: how far beside the best one, where nothing better is promised,
CLOSE = 1e-4  # of it: what is promised no further away than that is no better


class Look(NamedTuple):
    """What an initial h leaves: the error, m, shape (n,), and its squares' sum."""

    error: Array
    squares: float  # infinite where a law diverged

    @classmethod
    def at(cls, error: Array) -> Look:
        """The look that found an error."""
        squares = float(error @ error)
        return cls(error, squares if math.isfinite(squares) else math.inf)


Looks = Mapping[float, Look]  # by the initial h, m


def least_squares_h(left: Callable[[float], Array], bound: float) -> float:
    """The initial h, m, within +-bound that leaves the least squares of what was tried.

    They may have a minimum on each side of zero, so all of the range is looked at first. Between
    two looks what is left runs about straight: where it is least follows from both.
    """
    tried = {float(h): Look.at(left(float(h))) for h in np.linspace(-bound, bound, LOOKS)}
    h = min((_between(tried, *pair) for pair in pairwise(tried)), key=lambda way: way[1])[0]
    for _ in range(CLOSER):
        if abs(h - _least(tried)) < CLOSE * bound:
            h = _beside(tried, bound)
            if abs(h - _least(tried)) < CLOSE * bound:
                return h
        tried[h] = Look.at(left(h))
        best = _least(tried)
        ways = (_between(tried, best, other) for other in _neighbours(tried, best))
        h = min(ways, key=lambda way: way[1])[0]
    return _least(tried)


def _beside(tried: Looks, bound: float) -> float:
    """Where to look if the ways from the best h to its neighbours lead back to it.

    Close by, to see whether they are straight; from there as a step of Gauss and Newton leads, no
    further than halfway to what was tried.
    """
    best = _least(tried)
    around = _neighbours(tried, best)
    near = min((other for other in around if other != best), key=lambda h: abs(h - best))
    if abs(near - best) > 2.0 * BESIDE * bound:
        return best + math.copysign(BESIDE * bound, near - best)
    low, high = (0.5 * (best + other) for other in around)
    return min(high, max(low, best + _share(tried, best, near) * (near - best)))


def _least(tried: Looks) -> float:
    """The h that left the least squares, the smallest of several."""
    return min(tried, key=lambda h: (tried[h].squares, abs(h)))


def _neighbours(tried: Looks, h: float) -> tuple[float, float]:
    """The next lower and the next higher h that was tried, or h itself."""
    return (
        max((other for other in tried if other < h), default=h),
        min((other for other in tried if other > h), default=h),
    )


def _between(tried: Looks, h: float, other: float) -> tuple[float, float]:
    """Where on the straight way from one h to another the squares are least, and these."""
    share = min(1.0, max(0.0, _share(tried, h, other)))
    if share == 0.0:
        return h, tried[h].squares
    there = Look.at((1.0 - share) * tried[h].error + share * tried[other].error)
    return h + share * (other - h), there.squares


def _share(tried: Looks, h: float, other: float) -> float:
    """The share of the way to another h after which the squares would be least were it straight."""
    if math.isinf(tried[h].squares) or math.isinf(tried[other].squares):
        return 0.0
    change = Look.at(tried[other].error - tried[h].error)
    return -float(tried[h].error @ change.error) / change.squares if change.squares > 0.0 else 0.0
