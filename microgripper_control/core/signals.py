"""What travels along the chain: the rows of the bus and how a signal runs inside a step.

Every link reads and writes one array, the bus, of shape (rows, steps). Column j belongs to internal
step j and holds each signal's value at the *end* of that step. How the signal got there since the
step before is its course:

- stepped: it jumped at the start of the step and was held (a DAC's zero-order hold);
- ramped: it ran straight from the last value to this one (any continuous signal).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.compiled import compiled

Array = NDArray[np.float64]

VOLTAGE = 0  # V, at the piezo stack
HYSTERESIS = 1  # m, the Bouc-Wen variable h
FREE = 2  # m, what the stack would move without the flexure: d u - h
POSITION = 3  # m, displacement of the finger, then the sensor's reading of it
ROWS = 4

# What links tell each other beside the levels at which these rest when a run begins:
# the same rows where the drive's range ends (or u, if that lies beyond), in settled loops
LOW, HIGH = ROWS, 2 * ROWS
PLACES = np.array([0, LOW, HIGH])  # where the rows begin: who writes a level writes it at all three
RISEN, FALLEN = 3 * ROWS, 3 * ROWS + 1  # how far h speaks for a way up, and down, from these ends
FEED, LOOPS = RISEN + 2, RISEN + 3  # m/V that feed h; after how many such loops they have settled
LEVELS = RISEN + 4


@dataclass(frozen=True)
class Timing:
    """The internal time grid: how one sample period is divided, and the course of the signal.

    `steps` are the durations of the internal steps of one sample period, s, and sum to it. They
    need not be equal: a delay of a fraction of a sample puts a boundary exactly there.
    `quiet` are the steps, by index, at whose start a stepped voltage does not jump.
    """

    sample_period: float
    steps: tuple[float, ...]
    ramped: bool
    quiet: frozenset[int] = frozenset()

    @classmethod
    def divide(
        cls, sample_period: float, jumps: set[float], breaks: set[float], ramped: bool
    ) -> Timing:
        """Divide a sample period at `jumps` of a stepped voltage and `breaks`, shares in [0, 1)."""
        edges = [*sorted({0.0} | jumps | breaks), 1.0]
        steps = tuple((end - begin) * sample_period for begin, end in pairwise(edges))
        quiet = frozenset(i for i, edge in enumerate(edges[:-1]) if edge not in jumps)
        return cls(sample_period, steps, ramped, quiet)

    @property
    def ends(self) -> Array:
        """Where in the sample period each step ends, s, shape (steps,)."""
        return np.cumsum(self.steps)

    def with_course(self, ramped: bool) -> Timing:
        """The same grid for a signal of the given course."""
        return self if ramped == self.ramped else replace(self, ramped=ramped)


@compiled
def is_flat(bus: Array, share: float) -> bool:
    """Whether each row of a bus stays within a share of the value it ends at."""
    for row in range(bus.shape[0]):
        end = bus[row, -1]
        for step in range(bus.shape[1]):
            if not abs(bus[row, step] - end) <= share * abs(end):
                return False
    return True
