"""Recordings as CSV, with a header such as `time_s,voltage_V,displacement_m`.

The columns may stand in any order, further ones are ignored, `setpoint_m` may be there, too.
"""

from __future__ import annotations

from pathlib import Path

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import written_whole
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.core.table import Table
from microgripper_control.recordings.clock import on_uniform_clock
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.samples import Samples

USUAL_COLUMNS = {
    "time": "time_s",
    "voltage": "voltage_V",
    "displacement": "displacement_m",
    "setpoint": "setpoint_m",
}


def read_csv(path: Path, mapping: Mapping, *, needs_displacement: bool) -> Recording:
    """Read a CSV; MicrogripperError names the line or the column that is wrong."""
    needed = {"time", "voltage"} | ({"displacement"} if needs_displacement else set())
    usual = ",".join(USUAL_COLUMNS[quantity] for quantity in ("time", "voltage", "displacement"))
    table = Table.opened(path, usual)
    columns: dict[str, int] = {}
    for quantity in USUAL_COLUMNS:
        index = _find_column(table, quantity, mapping, quantity in needed)
        if index is not None:
            columns[quantity] = index
    rows = table.numbers(list(columns.values()), sparse=columns.get("setpoint"))
    notes = ("the last line is cut off: it was left out",) if rows.cut else ()
    values: dict[str, Array] = {}
    for quantity, numbers in zip(columns, rows.values.T, strict=True):
        source = getattr(mapping, quantity)
        values[quantity] = numbers * (source.scale if source else 1.0)
    samples = Samples(
        values["time"], values["voltage"], values.get("displacement"), values.get("setpoint")
    )
    return on_uniform_clock(str(path), samples, notes)


def write_csv(path: str | Path, recording: Recording) -> None:
    """Write `time_s,voltage_V` and what else was recorded, each number as it is.

    A time since 1970 is so to 0.24 µs, its last digit here; a bag keeps the nanoseconds.
    Samples that were filled in are left out: whoever reads the file fills them in and knows it.
    """
    columns = {"time_s": recording.time, "voltage_V": recording.voltage}
    if recording.displacement is not None:
        columns["displacement_m"] = recording.displacement
    if recording.setpoint is not None:
        columns["setpoint_m"] = recording.setpoint
    with written_whole(path) as file:
        file.write(",".join(columns) + "\n")
        recorded = recording.present
        for row in zip(*(column[recorded].tolist() for column in columns.values()), strict=True):
            file.write(",".join(map(repr, row)) + "\n")


def _find_column(table: Table, quantity: str, mapping: Mapping, needed: bool) -> int | None:
    source = getattr(mapping, quantity)
    name = source.column if source else USUAL_COLUMNS[quantity]
    if table.header.count(name) == 1:
        return table.header.index(name)
    if name in table.header:
        raise MicrogripperError(
            f"{table.path}: {table.header.count(name)} columns are named {name!r}"
        )
    if needed or source:
        raise MicrogripperError(
            f"{table.path}: no column {name!r}; it has {', '.join(table.header)}; "
            f"choose one with --map {quantity}=COLUMN"
        )
    return None
