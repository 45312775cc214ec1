"""Notes when samples were sent and when answers came, for the benchmark."""

from __future__ import annotations

import json
import time
from pathlib import Path


class RoundTrips:
    """Two rows of times, s of the monotonic clock; `write` keeps them as `sent` and `answered`."""

    def __init__(self, out: str | Path) -> None:
        self._out = Path(out)
        self._sent: list[float] = []
        self._answered: list[float] = []

    def sent(self) -> None:
        """A sample is about to be published."""
        self._sent.append(time.monotonic())

    def answered(self) -> None:
        """An answer has come."""
        self._answered.append(time.monotonic())

    def write(self) -> None:
        """Write the file, JSON."""
        times = {"sent": self._sent, "answered": self._answered}
        self._out.write_text(json.dumps(times), encoding="utf-8")
