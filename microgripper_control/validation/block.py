"""A signal over some steps of a uniform time grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(slots=True)
class Block:
    """What one part of the rig is given to change.

    `signal[j]` is the value at the *end* of step j, that is at `time` + (j + 1) `step` (s), and is
    changed in place. `voltage[j]` (V) is what the stack is driven with over the same steps, and
    `slant[j]` how it gets there: 0 where it jumps at the beginning of the step and is held, 1 where
    it runs straight from the value before, in between by what has the same mean. Time zero is the
    first sample of the recording; before it lies the rig's past.
    """

    time: float
    step: float
    signal: Array
    voltage: Array
    slant: Array

    @property
    def times(self) -> Array:
        """The instants of the values, s."""
        steps: Array = np.arange(1.0, len(self.signal) + 1.0)
        return self.time + self.step * steps
