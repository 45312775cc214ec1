"""Step, staircase, ramp, triangle and sine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.control.declared import declared
from microgripper_control.control.setpoints.base import Ranged, Ticks, whole_ticks
from microgripper_control.core.signals import Array


@dataclass(frozen=True)
class Step(Ranged):
    """`low` until `start`, then `high`."""

    start: float = declared("s", 1.0, 0.0, 1e6, "when it steps")

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        return self.between((k >= round(self.start / sample_period)).astype(np.float64))


@dataclass(frozen=True)
class Staircase(Ranged):
    """From `low` to `high` in equal steps and back again, over and over."""

    steps: float = declared("1", 5, 1, 1e4, "number of steps each way", whole=True)
    hold: float = declared("s", 0.5, 1e-6, 1e6, "time on each level")

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        steps = round(self.steps)
        level = (k // whole_ticks(self.hold, sample_period)) % (2 * steps)
        return self.between(np.minimum(level, 2 * steps - level) / steps)


@dataclass(frozen=True)
class Ramp(Ranged):
    """`low` until `start`, then straight to `high`, and held there."""

    start: float = declared("s", 0.0, 0.0, 1e6, "when it begins to move")
    duration: float = declared("s", 1.0, 1e-6, 1e6, "time from low to high")

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        since = k - round(self.start / sample_period)
        return self.between(np.clip(since / whole_ticks(self.duration, sample_period), 0.0, 1.0))


@dataclass(frozen=True)
class Triangle(Ranged):
    """From `low` straight to `high` and back, over and over."""

    frequency: float = declared("Hz", 1.0, 1e-6, 1e5, "cycles a second")

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        cycles = np.mod(k * (self.frequency * sample_period), 1.0)
        return self.between(1.0 - np.abs(2.0 * cycles - 1.0))


@dataclass(frozen=True)
class Sine(Ranged):
    """From `low`, where it starts at rest, to `high` and back.

    low + (high - low) (1 - cos(2 pi frequency t + phase)) / 2
    """

    frequency: float = declared("Hz", 1.0, 1e-6, 1e5, "cycles a second")
    phase: float = declared("rad", 0.0, -6.3, 6.3, "phase at the start; pi/2: rising in the middle")

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        cycles = np.mod(k * (self.frequency * sample_period), 1.0)
        return self.between(0.5 - 0.5 * np.cos(2.0 * np.pi * cycles + self.phase))
