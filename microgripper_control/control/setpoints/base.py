"""The contract of a setpoint: sample k has a value, whatever was asked before.

A setpoint does not know its quantity: displacement in m for the closed-loop modes, voltage in V in
open loop. Its times are rounded to whole sample periods, so that nothing depends on how k T rounds.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microgripper_control.control.declared import Declared, declared
from microgripper_control.core.signals import Array

Ticks = NDArray[np.int64]

UNIT = "m or V"
LARGEST = 1e4  # V; far beyond any displacement


@dataclass(frozen=True)
class Setpoint(Declared, ABC):
    """A signal of sample numbers; sample 0 is its first."""

    @abstractmethod
    def values(self, k: Ticks, sample_period: float) -> Array:
        """The values at samples k >= 0 (any shape) of `sample_period` (s), elementwise."""

    def at(self, k: int, sample_period: float) -> float:
        """The value at one sample; the very number that `samples` has there."""
        return float(self.values(np.array([k]), sample_period)[0])

    def samples(self, count: int, sample_period: float) -> Array:
        """The values at samples 0 .. count-1, shape (count,)."""
        return self.values(np.arange(count), sample_period)


@dataclass(frozen=True)
class Ranged(Setpoint):
    """A setpoint that begins at `low` and moves between it and `high`, whichever is larger."""

    low: float = declared(UNIT, 0.0, -LARGEST, LARGEST, "value at the start")
    high: float = declared(UNIT, 1e-5, -LARGEST, LARGEST, "value farthest from the start")

    def between(self, share: Array) -> Array:
        """`low` where share is 0, `high` where it is 1."""
        return self.low + (self.high - self.low) * share


def whole_ticks(duration: float, sample_period: float) -> int:
    """A duration, s, in sample periods, at least one."""
    return max(1, round(duration / sample_period))
