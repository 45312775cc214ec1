"""What a rig is driven with: the samples of a voltage, and how it runs between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array

KNOTS = 8  # a sample, of a voltage that runs on between the samples


@compiled
def between_knots(knots: Array, first: int, last: int, steps: int) -> Array:
    """The voltage at the end of each of `steps` internal steps of the samples first .. last - 1."""
    voltage = np.empty((last - first) * steps)
    for j in range(len(voltage)):
        at = first * KNOTS + (j + 1) * KNOTS / steps
        i = min(int(at), len(knots) - 2)
        voltage[j] = knots[i] + (at - i) * (knots[i + 1] - knots[i])
    return voltage


@dataclass(frozen=True)
class Drive:
    """Voltages from the rig's past to the end of the recording.

    `samples[j]` (V) belongs to the instant (j - `past_samples`) `sample_period`; it is applied from
    there on and held where `knots` is None. Otherwise the samples are readings of an analog
    voltage, which runs straight from one knot to the next; sample j is knot j `KNOTS`.
    """

    sample_period: float
    past_samples: int
    samples: Array
    knots: Array | None = None

    def __len__(self) -> int:
        return len(self.samples)

    @property
    def past(self) -> float:
        """Before the recording's first sample, s."""
        return self.past_samples * self.sample_period

    @property
    def duration(self) -> float:
        """Of the recording, s."""
        return (len(self.samples) - self.past_samples) * self.sample_period

    @property
    def recorded(self) -> Array:
        """The samples of the recording."""
        return self.samples[self.past_samples :]

    def instant(self, j: int) -> float:
        """Of sample j, s; zero is the recording's first."""
        return (j - self.past_samples) * self.sample_period

    def internal(self, first: int, last: int, steps: int) -> Array:
        """The voltage at the end of each internal step of the samples first .. last - 1."""
        if self.knots is None:
            return np.repeat(self.samples[first:last], steps)
        return between_knots(self.knots, first, last, steps)
