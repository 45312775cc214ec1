"""The newest rows of a stream of numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import Array


class Sliding:
    """Keeps the newest `most` rows of a stream, in order and in one piece of memory."""

    def __init__(self, most: int, columns: int) -> None:
        self._most = most
        self._data = np.empty((2 * most, columns))
        self._end = 0

    def __len__(self) -> int:
        return min(self._end, self._most)

    @property
    def is_full(self) -> bool:
        """Whether the next row drives out the oldest one."""
        return self._end >= self._most

    @property
    def columns(self) -> Array:
        """The rows so far, column by column: shape (columns, rows), a copy."""
        newest: Array = self._data[self._end - len(self) : self._end].T.copy()
        return newest

    def append(self, row: Sequence[float]) -> None:
        """Add the newest row."""
        if self._end == len(self._data):
            self._data[: self._most] = self._data[self._most :]
            self._end = self._most
        self._data[self._end] = row
        self._end += 1

    def clear(self) -> None:
        """Forget all rows."""
        self._end = 0
