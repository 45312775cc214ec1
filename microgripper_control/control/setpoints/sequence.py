"""Setpoints one after the other: a staircase, then a triangle, then a sine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.control.setpoints.base import Setpoint, Ticks, whole_ticks
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array


@dataclass(frozen=True)
class Sequence(Setpoint):
    """Segments of a setpoint and its duration, s; each starts at its own sample 0.

    After the last one its last value is held. Raises MicrogripperError if there is none or a
    duration is not positive.
    """

    segments: tuple[tuple[Setpoint, float], ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.segments:
            raise MicrogripperError("Sequence: no segments; give at least one")
        for number, (_, duration) in enumerate(self.segments, 1):
            if not 0.0 < duration < float("inf"):
                raise MicrogripperError(
                    f"Sequence: segment {number}: duration {duration:g} s must be positive"
                )

    def boundaries(self, sample_period: float) -> tuple[int, ...]:
        """The first sample of each segment, then the first after the last."""
        lengths = [whole_ticks(duration, sample_period) for _, duration in self.segments]
        return tuple(int(edge) for edge in np.cumsum([0, *lengths]))

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        edges = self.boundaries(sample_period)
        k = np.minimum(k, edges[-1] - 1)
        result = np.empty(k.shape)
        for (setpoint, _), start, end in zip(self.segments, edges, edges[1:], strict=False):
            inside = (k >= start) & (k < end)
            result[inside] = setpoint.values(k[inside] - start, sample_period)
        return result
