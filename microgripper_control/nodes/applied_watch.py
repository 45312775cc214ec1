"""Notices that the plant does not apply the voltages that it is sent.

It may not be listening yet, or its own guard may be at work, or somebody else may be sending. A
control law that goes on meanwhile winds up, and the gripper jumps when the plant obeys at last. So
the law then begins again from what the plant applies, gently until it is proved to obey.
"""

from __future__ import annotations

import math
from collections import deque

IN_ROW = 5  # samples; fewer prove nothing


class AppliedWatch:
    """`patience` is how long a voltage may be on its way, s, `tolerance` how well it is read, V.

    `proved` is whether the plant has followed since the last beginning; `refusals` counts the times
    it was seen not to.
    """

    def __init__(self, patience: float, tolerance: float) -> None:
        self._patience = patience
        self._tolerance = tolerance
        self._sent: deque[tuple[float, float]] = deque()
        self._base = math.nan
        self._right = self._wrong = 0  # in a row
        self.proved = False
        self.refusals = 0

    @property
    def state(self) -> str:
        """In words."""
        return "ok" if self.proved else "not proved"

    def begin(self, voltage: float) -> None:
        """Begin at a voltage, V, that the plant applies."""
        self._sent.clear()
        self._base, self.proved = voltage, False
        self._right = self._wrong = 0

    def sent(self, voltage: float, now: float) -> None:
        """Note a voltage, V, that went out at `now`, s."""
        self._sent.append((now, voltage))
        while len(self._sent) > 1 and self._sent[1][0] < now - self._patience:
            self._sent.popleft()

    def follows(self, applied: float) -> bool:
        """Whether the plant, which reports `applied`, V, does as it was told."""
        if not self._sent:
            return True
        newest = self._sent[-1][0]
        ways = [newest - at for at, voltage in self._sent if self._equal(applied, voltage)]
        if not ways:
            self._right, self._wrong = 0, self._wrong + 1
            refuses = self._wrong >= IN_ROW
            self.refusals += refuses
            return not refuses
        # On a ramp of its own a plant may happen to be where it should have been some time ago.
        self._right, self._wrong = self._right + 1 if ways[-1] <= 0.5 * self._patience else 0, 0
        has_moved = not self._equal(applied, self._base)
        self.proved = self.proved or (has_moved and self._right >= IN_ROW)
        return True

    def _equal(self, one: float, other: float) -> bool:
        return abs(one - other) <= self._tolerance
