"""A setpoint from a CSV file: a column of values beside `time_s`."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from microgripper_control.control.setpoints.base import Setpoint, Ticks
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array

TIME = "time_s"
SAME_INSTANT = 1e-6  # of a sample period


@dataclass(frozen=True, eq=False)
class Recorded(Setpoint):
    """Each value from its time on, until the next; the last one for good.

    `times` (s, from 0 on, rising) and `points` have the same shape (n,), n >= 1.
    """

    times: Array
    points: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.times) == 0 or self.times.shape != self.points.shape:
            raise MicrogripperError(
                f"Recorded: {len(self.times)} times for {len(self.points)} points"
            )

    def values(self, k: Ticks, sample_period: float) -> Array:
        """As the contract says."""
        instants = (k + SAME_INSTANT) * sample_period
        return self.points[np.searchsorted(self.times, instants, side="right") - 1]


def read_recorded(path: str | Path, column: str | None = None) -> Recorded:
    """Read a CSV with a header; time counts from the file's first row.

    `column` names the values; without it the file must have exactly one besides `time_s`. Raises
    MicrogripperError naming the file and what is wrong.
    """
    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if row]
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise MicrogripperError(f"{path}: is not a CSV text file") from None
    if len(rows) < 2:
        raise MicrogripperError(f"{path}: a header and at least one row are needed")
    header = [name.strip() for name in rows[0]]
    time_at, value_at = _columns(path, header, column)
    times = np.array([_number(path, row, time_at, n) for n, row in enumerate(rows[1:], 1)])
    points = np.array([_number(path, row, value_at, n) for n, row in enumerate(rows[1:], 1)])
    backwards = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backwards):
        raise MicrogripperError(f"{path}: row {backwards[0] + 2}: {TIME} must rise")
    return Recorded(times - times[0], points)


def _columns(path: Path, header: list[str], column: str | None) -> tuple[int, int]:
    present = ", ".join(header)
    if TIME not in header:
        raise MicrogripperError(f"{path}: no column {TIME}; there are {present}")
    if column is None:
        others = [name for name in header if name != TIME]
        if len(others) != 1:
            raise MicrogripperError(f"{path}: choose a column; there are {present}")
        column = others[0]
    if column not in header:
        raise MicrogripperError(f"{path}: no column {column}; there are {present}")
    return header.index(TIME), header.index(column)


def _number(path: Path, row: list[str], at: int, number: int) -> float:
    try:
        value = float(row[at])
    except (IndexError, ValueError):
        given = row[at] if at < len(row) else ""
        raise MicrogripperError(f"{path}: row {number}: {given!r:.40} is not a number") from None
    if not math.isfinite(value):
        raise MicrogripperError(f"{path}: row {number}: {value} is not finite")
    return value
