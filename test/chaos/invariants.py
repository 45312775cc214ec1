"""What must hold of the voltages on the topic, whatever happens around them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from nursery import PERIOD

LOW, HIGH = 0.0, 160.0  # V
RATE = 2e4  # V/s, the controller's default
ROUNDING = 1e-6  # V
SHOWN = 5  # violations that are described


@dataclass
class Invariants:
    """Checks voltage by voltage: finite, in range, in rate.

    Two messages that are published closer together than a sample period may differ by what the rate
    allows in one: when exactly a message got its time of publication is up to the scheduler.
    """

    period: float = PERIOD  # s, of a sample
    count: int = 0
    lowest: float = math.inf  # V
    highest: float = -math.inf  # V
    worst_rate: float = 0.0  # V/s
    violations: int = 0
    described: list[str] = field(default_factory=list)
    _last: tuple[float, float] | None = None  # s, V

    def note(self, at: float, voltage: float) -> None:
        """Check a voltage, V, published at `at`, s."""
        self.count += 1
        if not math.isfinite(voltage):
            self._violated(at, f"{voltage} V")
            return
        self.lowest, self.highest = min(self.lowest, voltage), max(self.highest, voltage)
        if not LOW <= voltage <= HIGH:
            self._violated(at, f"{voltage} V is out of range")
        if self._last is not None:
            then, before = self._last
            allowed = RATE * max(at - then, self.period) + ROUNDING
            change = abs(voltage - before)
            self.worst_rate = max(self.worst_rate, change / max(at - then, self.period))
            if change > allowed:
                self._violated(at, f"{before:.3f} to {voltage:.3f} V in {1e3 * (at - then):.3f} ms")
        self._last = at, voltage

    def anew(self) -> Invariants:
        """One that goes on from the last voltage."""
        return Invariants(self.period, _last=self._last)

    def _violated(self, at: float, what: str) -> None:
        self.violations += 1
        if len(self.described) < SHOWN:
            self.described.append(f"{what}, at {at:.6f} s")
