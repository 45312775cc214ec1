"""The voltage guard: the last thing before a voltage is published.

Whatever it is given, each answer is finite, within the range, and within the rate of the last one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from microgripper_control.control.declared import Declared, declared
from microgripper_control.core.errors import MicrogripperError


@dataclass(frozen=True)
class VoltageLimits(Declared):
    """What the drive voltage may do; MicrogripperError names limits that contradict each other."""

    low: float = declared("V", 0.0, -1e4, 1e4, "lowest voltage")
    high: float = declared("V", 160.0, -1e4, 1e4, "highest voltage")
    rate: float = declared("V/s", 2e4, 1.0, 1e9, "fastest change while controlling")
    safe: float = declared("V", 0.0, -1e4, 1e4, "voltage to end at")
    ramp_rate: float = declared("V/s", 2000.0, 1.0, 1e9, "change on the way to the safe voltage")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.low < self.high:
            raise MicrogripperError(
                f"VoltageLimits: low = {self.low:g} V must be below high = {self.high:g} V"
            )
        if not self.low <= self.safe <= self.high:
            raise MicrogripperError(
                f"VoltageLimits: safe = {self.safe:g} V must lie within "
                f"low .. high = {self.low:g} .. {self.high:g} V"
            )
        if self.ramp_rate > self.rate:
            raise MicrogripperError(
                f"VoltageLimits: ramp_rate = {self.ramp_rate:g} V/s must not exceed "
                f"rate = {self.rate:g} V/s"
            )

    def clip(self, voltage: float) -> float:
        """The nearest voltage in range, V; `voltage` must not be NaN."""
        return self.low if voltage < self.low else self.high if voltage > self.high else voltage


class VoltageGuard:
    """Holds the last voltage that went out and lets the next one follow it.

    `lowest` and `highest` are the voltages, V, between which the next one may go out.
    """

    def __init__(self, limits: VoltageLimits, sample_period: float) -> None:
        self._limits = limits
        self._period = sample_period
        self._largest_change = limits.rate * sample_period
        self._ramp_change = limits.ramp_rate * sample_period
        self._stand_at(limits.safe)

    @property
    def limits(self) -> VoltageLimits:
        """The limits it keeps."""
        return self._limits

    @property
    def voltage(self) -> float:
        """The last voltage that went out, V."""
        return self._voltage

    def start(self, reported: float, elapsed: float = math.inf) -> float:
        """Begin at the voltage that the plant reports, V; the range comes first if it is outside.

        Where a voltage went out `elapsed` s ago the rate comes first, too. Raises MicrogripperError
        if the report is not finite: there is nothing to begin from.
        """
        if not math.isfinite(reported):
            raise MicrogripperError(f"plant: reports {reported} V; wait for a finite voltage")
        change = self._limits.rate * max(elapsed, 0.0)
        near = min(max(reported, self._voltage - change), self._voltage + change)
        self._stand_at(self._limits.clip(near))
        return self._voltage

    def passed(self, elapsed: float) -> None:
        """Say how long ago the last voltage went out, s: the next one follows it at the rate.

        A sample period at most, and without this call a sample period: what comes late may not
        jump, and samples that come too fast must not make the voltage fast.
        """
        self._largest_change = self._limits.rate * min(max(elapsed, 0.0), self._period)
        self._stand_at(self._voltage)

    def step(self, command: float) -> float:
        """The voltage to publish for a command, V; NaN and infinities repeat the last one."""
        if math.isfinite(command):
            low, high = self.lowest, self.highest
            self._stand_at(low if command < low else high if command > high else command)
        return self._voltage

    def ramp_to(self, goal: float) -> float:
        """One step towards `goal`, V, at the ramp rate; call until the answer no longer changes."""
        if math.isfinite(goal):
            goal = self._limits.clip(goal)
            most = min(self._ramp_change, self._largest_change)
            change = min(max(goal - self._voltage, -most), most)
            # Not the sum where the goal is in reach: rounding must not keep it from arriving.
            arrives = abs(change) < most
            self._stand_at(self._limits.clip(goal if arrives else self._voltage + change))
        return self._voltage

    def _stand_at(self, voltage: float) -> None:
        self._voltage = voltage
        lowest, highest = voltage - self._largest_change, voltage + self._largest_change
        low, high = self._limits.low, self._limits.high
        self.lowest = lowest if lowest > low else low
        self.highest = highest if highest < high else high
