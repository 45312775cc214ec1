"""How long nothing was heard, as far as this process was awake to hear it."""

from __future__ import annotations

import math


class Silence:
    """Is over once nothing was heard for `limit`, s; a limit of 0 is never over.

    A process that was itself held up finds the time gone and the messages still in its queue. So of
    the time between two looks at most half the limit counts.
    """

    def __init__(self, limit: float) -> None:
        self.limit = limit or math.inf
        self._length = 0.0
        self._looked = math.nan

    def heard(self, now: float) -> None:
        """Begin again at `now`, s."""
        self._length, self._looked = 0.0, now

    def is_over(self, now: float) -> bool:
        """Look, at `now`, s; it does not begin before something was heard."""
        if math.isnan(self._looked):
            return False
        self._length += min(now - self._looked, 0.5 * self.limit)
        self._looked = now
        return self._length >= self.limit

    @property
    def left(self) -> float:
        """Time until it is over if nothing is heard, s; 0 if it is."""
        return math.inf if math.isnan(self._looked) else max(0.0, self.limit - self._length)
