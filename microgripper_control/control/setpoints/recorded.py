"""A setpoint from a CSV file: a column of values beside `time_s`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from microgripper_control.control.setpoints.base import Setpoint, Ticks
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.core.table import Table

TIME = "time_s"
SAME_INSTANT = 1e-3  # of a sample period: times are rounded


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
    table = Table.opened(path, f"{TIME},setpoint_m")
    time_at = table.column(TIME)
    if column is None:
        others = [name for name in table.header if name != TIME]
        if len(others) != 1:
            raise MicrogripperError(f"{path}: choose a column of {', '.join(others)}")
        (column,) = others
    times, points = table.whole_numbers([time_at, table.column(column)]).T
    if not len(times):
        raise MicrogripperError(f"{path}: has no rows; at least one is needed")
    for name, values in ((TIME, times), (column, points)):
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise MicrogripperError(f"{path}: row {bad[0] + 1}: {name} is {values[bad[0]]}")
    backwards = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backwards):
        raise MicrogripperError(f"{path}: row {backwards[0] + 2}: {TIME} must rise")
    return Recorded(times - times[0], points)
