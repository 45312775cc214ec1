"""CSV with a header such as `time_s,voltage_V,displacement_m`.

The columns may stand in any order, further ones are ignored, `setpoint_m` may be there, too.
Commas, semicolons or tabs separate them.
"""

from __future__ import annotations

import csv
import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import written_whole
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.recordings.clock import Samples, on_uniform_clock
from microgripper_control.recordings.mapping import Mapping

USUAL_COLUMNS = {
    "time": "time_s",
    "voltage": "voltage_V",
    "displacement": "displacement_m",
    "setpoint": "setpoint_m",
}
DELIMITERS = ",;\t"
LONGEST_HEADER = 65536  # characters


def read_csv(path: Path, mapping: Mapping, *, needs_displacement: bool) -> Recording:
    """Read a CSV; MicrogripperError names the line or the column that is wrong."""
    needed = {"time", "voltage"} | ({"displacement"} if needs_displacement else set())
    try:
        header, delimiter = _read_header(path, _usual_header())
        columns: dict[str, int] = {}
        for quantity in USUAL_COLUMNS:
            index = _find_column(path, header, quantity, mapping, quantity in needed)
            if index is not None:
                columns[quantity] = index
        setpoint = columns.get("setpoint")
        table = _read_numbers(path, header, delimiter, list(columns.values()), setpoint)
        cut = not _end(path).endswith(("\n", "\r"))
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be read: {error.strerror}") from None
    values: dict[str, Array] = {}
    for quantity, numbers in zip(columns, table.T, strict=True):
        source = getattr(mapping, quantity)
        values[quantity] = numbers * (source.scale if source else 1.0)
    samples = Samples(
        values["time"], values["voltage"], values.get("displacement"), values.get("setpoint")
    )
    if not cut:
        return on_uniform_clock(str(path), samples)
    note = "the last line has no end and may be cut off within a number: it was left out"
    return on_uniform_clock(str(path), samples.where(np.arange(len(table) - 1)), (note,))


def write_csv(path: str | Path, recording: Recording) -> None:
    """Write `time_s,voltage_V` and what else was recorded; every digit is kept.

    Samples that were filled in are left out: whoever reads the file fills them in and knows it.
    """
    columns = {"time_s": recording.time, "voltage_V": recording.voltage}
    if recording.displacement is not None:
        columns["displacement_m"] = recording.displacement
    if recording.setpoint is not None:
        columns["setpoint_m"] = recording.setpoint
    with written_whole(path) as file:
        file.write(",".join(columns) + "\n")
        read = recording.present
        for row in zip(*(column[read].tolist() for column in columns.values()), strict=True):
            file.write(",".join(map(repr, row)) + "\n")


def read_columns(path: Path, names: Sequence[str]) -> Array:
    """The numbers of the named columns of a CSV of something else, shape (rows, columns).

    Raises MicrogripperError as `read_csv` does.
    """
    try:
        header, delimiter = _read_header(path, ",".join(names))
        for name in names:
            if header.count(name) != 1:
                count = header.count(name) or "no"
                raise MicrogripperError(
                    f"{path}: {count} columns named {name!r} where one is needed; "
                    f"it has {', '.join(header)}"
                )
        return _read_numbers(path, header, delimiter, [header.index(name) for name in names])
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be read: {error.strerror}") from None


def _opened(path: Path) -> TextIO:
    # Only the names of the columns are text: a foreign encoding spoils at most those.
    return path.open(encoding="utf-8-sig", errors="replace", newline="")


def _read_header(path: Path, usual: str) -> tuple[list[str], str]:
    """The names of the columns and what separates them; `usual` is what they should be."""
    with _opened(path) as file:
        line = file.readline(LONGEST_HEADER)
    if not line.strip():
        raise MicrogripperError(f"{path}: is empty; expected a header such as {usual}")
    if "\0" in line or "\ufffd\ufffd" in line:
        raise MicrogripperError(f"{path}: is neither a rosbag2 nor a CSV in UTF-8")
    delimiter = max(DELIMITERS, key=line.count)  # of as many the first
    header = [name.strip() for name in next(csv.reader([line], delimiter=delimiter))]
    if all(_is_number(name) for name in header):
        raise MicrogripperError(
            f"{path}: line 1 has numbers where the names of the columns should be, such as {usual}"
        )
    _check_width(path, header, delimiter)
    return header, delimiter


def _check_width(path: Path, header: list[str], delimiter: str) -> None:
    """Raise MicrogripperError if a row has more cells than names: 5,002 is two of them.

    The first and the last are looked at: one of them may have whole numbers only.
    """
    with _opened(path) as file:
        reader = csv.reader(file, delimiter=delimiter)
        try:
            next(reader)
            first = next((row for row in reader if any(cell.strip() for cell in row)), [])
            last = next(csv.reader(_end(path).splitlines()[-1:], delimiter=delimiter), [])
        except csv.Error:
            return  # told where the row is read
        for which, row in ((f"line {reader.line_num}", first), ("the last line", last)):
            if any(cell.strip() for cell in row[len(header) :]):
                raise MicrogripperError(
                    f"{path}: {which}: {len(row)} cells, the header has {len(header)}; "
                    "with decimal commas, separate the columns by semicolons and write points"
                )


def _end(path: Path) -> str:
    """The last characters of a file."""
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - LONGEST_HEADER))
        return file.read().decode("latin-1")


def _usual_header() -> str:
    return ",".join(USUAL_COLUMNS[quantity] for quantity in ("time", "voltage", "displacement"))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _find_column(
    path: Path, header: list[str], quantity: str, mapping: Mapping, needed: bool
) -> int | None:
    source = getattr(mapping, quantity)
    name = source.column if source else USUAL_COLUMNS[quantity]
    if header.count(name) == 1:
        return header.index(name)
    if name in header:
        raise MicrogripperError(f"{path}: {header.count(name)} columns are named {name!r}")
    if needed or source:
        raise MicrogripperError(
            f"{path}: no column {name!r}; it has {', '.join(header)}; "
            f"choose one with --map {quantity}=COLUMN"
        )
    return None


def _read_numbers(
    path: Path,
    header: list[str],
    delimiter: str,
    columns: list[int],
    setpoint: int | None = None,
) -> Array:
    """The numbers of some columns, shape (rows, columns); that of the setpoint may have gaps."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a file without rows
            return np.loadtxt(
                path,
                delimiter=delimiter,
                skiprows=1,
                usecols=columns,
                ndmin=2,
                comments=None,
                quotechar='"',
                encoding="latin-1",
            )
    except ValueError:
        return _read_row_by_row(path, header, delimiter, columns, setpoint)


def _read_row_by_row(
    path: Path, header: list[str], delimiter: str, columns: list[int], setpoint: int | None
) -> Array:
    """As `_read_numbers`, slower, but able to name what is wrong and to leave out setpoints."""
    rows: list[list[float]] = []
    with _opened(path) as file:
        reader = csv.reader(file, delimiter=delimiter)
        try:
            next(reader)
            for row in reader:
                if any(cell.strip() for cell in row):
                    where = f"{path}: line {reader.line_num}"
                    rows.append([_number(row, index, header, where, setpoint) for index in columns])
        except csv.Error as error:
            raise MicrogripperError(f"{path}: line {reader.line_num}: {error}") from None
    return np.array(rows, dtype=float).reshape(len(rows), len(columns))


def _number(
    row: list[str], index: int, header: list[str], where: str, setpoint: int | None
) -> float:
    if index >= len(row):
        raise MicrogripperError(
            f"{where}: {len(row)} cells, none in column {header[index]!r}; complete or remove it"
        )
    cell = row[index].strip()
    if not cell and index == setpoint:
        return float("nan")
    try:
        return float(cell)
    except ValueError:
        raise MicrogripperError(
            f"{where}: {cell!r:.40} in column {header[index]!r} is not a number"
        ) from None
