"""What a file holds: every sample with a stamp of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array


@dataclass(frozen=True)
class Samples:
    """A recording as it was stored: every sample with a stamp of its own.

    `time` is in s, shape (n,), and counts from `origin` (s), so that stamps since 1970 keep their
    nanoseconds. `voltage` in V; `displacement` and `setpoint` in m.
    """

    time: Array
    voltage: Array
    displacement: Array | None = None
    setpoint: Array | None = None
    origin: float = 0.0

    def on(self, known: Array, wanted: Array) -> Samples:
        """Read the signals, known at increasing positions, off at others, one apart.

        Voltage and setpoint are those that hold for most of the way to the next position; the
        displacement runs straight.
        """
        held = np.searchsorted(known, wanted + 0.5, side="right") - 1
        displacement = self.displacement
        return Samples(
            time=np.interp(wanted, known, self.time),
            voltage=self.voltage[held],
            displacement=None if displacement is None else np.interp(wanted, known, displacement),
            setpoint=None if self.setpoint is None else self.setpoint[held],
            origin=self.origin,
        )

    def where(self, keep: NDArray[np.bool_] | NDArray[np.intp]) -> Samples:
        """Only the samples at which `keep` is true, or which it numbers."""
        return Samples(
            time=self.time[keep],
            voltage=self.voltage[keep],
            displacement=None if self.displacement is None else self.displacement[keep],
            setpoint=None if self.setpoint is None else self.setpoint[keep],
            origin=self.origin,
        )
