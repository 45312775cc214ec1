"""Notes when samples were sent and when answers came, for the benchmark."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np


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
        """Write the file, of numpy's npz."""
        np.savez(self._out, sent=self._sent, answered=self._answered)
