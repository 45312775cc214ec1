"""Each sample of the plant together with the setpoint for it.

A setpoint carries no stamp. The one for a sample is published in answer to that sample, so it comes
a moment after it, or, over another way, a moment before. How long it is waited for is what tells
lockstep from wall time: in lockstep until it comes; in wall time for a fraction of a sample, and
only while setpoints come at every sample: those set by hand are not waited for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Paired:
    """A sample and the newest setpoint that came since the last sample was taken, if one did."""

    displacement: float  # m
    voltage: float  # V
    setpoint: float | None  # m, or V in open loop


class Pairing:
    """Collects one sample and one setpoint at a time; `patience` is the longest wait, s."""

    def __init__(self, patience: float, *, lockstep: bool, awaits: bool = True) -> None:
        self._patience = patience
        self._lockstep = lockstep
        self._awaits = awaits
        self._sample: tuple[float, float] | None = None  # not yet taken
        self._setpoint: float | None = None  # not yet taken
        self._arrived = 0  # setpoints since the last sample
        self.deadline = math.inf  # s, when to take the sample without a setpoint
        self.surplus = 0  # setpoints that another one overtook

    @property
    def waiting(self) -> bool:
        """Whether there is a sample that was not taken."""
        return self._sample is not None

    def sample(self, displacement: float, voltage: float, now: float) -> bool:
        """Note a sample that came at `now`, s; whether it can be taken."""
        self._sample = displacement, voltage
        steady, self._arrived = self._arrived > 0, 0
        if self._lockstep:
            waits = self._awaits and self._setpoint is None
        else:
            # One that lies here may be late for the last sample or early for this one: the next
            # tells, since it would be the newer.
            waits = steady and self._patience > 0.0
        self.deadline = now + self._patience if waits else math.inf
        return not waits

    def setpoint(self, value: float) -> bool:
        """Note a setpoint; whether a sample waited for it and can be taken."""
        if self._setpoint is not None:
            self.surplus += 1
        if math.isfinite(value) or self._setpoint is None:  # a good one stays
            self._setpoint = value
        self._arrived += 1
        return self._sample is not None

    def drop(self) -> None:
        """Forget a sample that waits; a setpoint stays for the next."""
        self._sample = None
        self.deadline = math.inf

    def forget_setpoint(self) -> None:
        """Forget one that no sample has taken: another mode would read it in its own unit."""
        self._setpoint = None

    def take(self) -> Paired:
        """The sample that waits, with its setpoint if there is one."""
        assert self._sample is not None
        displacement, voltage = self._sample
        paired = Paired(displacement, voltage, self._setpoint)
        self._sample = self._setpoint = None
        self.deadline = math.inf
        return paired
