"""A CSV table of numbers: a header with the names of the columns, then rows.

Commas, semicolons or tabs separate them. Numbers have a decimal point. A row has no more cells than
there are names; a separator at its end does no harm.
"""

from __future__ import annotations

import csv
import os
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import refuse_pipe
from microgripper_control.core.signals import Array

DELIMITERS = ",;\t"
DECIMAL_POINTS = "numbers have decimal points, no commas"
LONGEST_HEADER = 65536  # characters
COUNTED_AT_ONCE = 2**24  # bytes
FEW = 10  # rows: of fewer the last is not judged by the others
LARGEST_STEP = 2.0  # of those before it: a last row without its end that goes farther is cut off


class Rows(NamedTuple):
    """Numbers, shape (rows, columns), and whether a last line that was `cut` off is left out."""

    values: Array
    cut: bool = False


@dataclass(frozen=True)
class Table:
    """A file, the names of its columns and what separates them."""

    path: Path
    header: list[str]
    delimiter: str

    @classmethod
    def opened(cls, path: str | Path, usual: str) -> Table:
        """The table in a file, whose header should be like `usual`.

        MicrogripperError says what is wrong with the header, or with the number of cells.
        """
        path = Path(path)
        with _readable(path):
            refuse_pipe(path)
            with _text(path) as file:
                line = _western(file.readline(LONGEST_HEADER))
            if not line.strip():
                wrong = "line 1 is blank" if line else "is empty"
                raise MicrogripperError(f"{path}: {wrong}; expected a header such as {usual}")
            if "\0" in line or "\ufffd\ufffd" in line:
                raise MicrogripperError(f"{path}: is neither a rosbag2 nor a CSV in UTF-8")
            delimiter = max(DELIMITERS, key=line.count)  # of as many the first
            header = [name.strip() for name in next(csv.reader([line], delimiter=delimiter))]
            if all(_is_number(name) for name in header):
                raise MicrogripperError(
                    f"{path}: line 1 has numbers where the names of the columns should be, such "
                    f"as {usual}"
                )
            table = cls(path, header, delimiter)
            table._check_width(usual)
            return table

    def column(self, name: str) -> int:
        """Where the one column of a name stands; MicrogripperError if there is none, or several."""
        if self.header.count(name) != 1:
            count = self.header.count(name) or "no"
            raise MicrogripperError(
                f"{self.path}: {count} columns named {name!r} where one is needed; "
                f"it has {', '.join(self.header)}"
            )
        return self.header.index(name)

    def numbers(self, columns: Sequence[int], sparse: int | None = None) -> Rows:
        """The numbers of some columns; that in `sparse` may be missing, which is NaN.

        MicrogripperError names the line, the cell and its column where there is no number, and the
        line where there are more cells than names.
        """
        with _readable(self.path):
            size, delimiters = self.path.stat().st_size, self._delimiters()
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # of a file without rows
                    values = np.loadtxt(
                        self.path,
                        delimiter=self.delimiter,
                        skiprows=1,
                        usecols=columns,
                        ndmin=2,
                        comments=None,
                        quotechar='"',
                        encoding="latin-1",
                    )
                wide = delimiters > (len(values) + 1) * (len(self.header) - 1)
                rows = self._row_by_row(columns, sparse, size) if wide else Rows(values)
            except ValueError:
                rows = self._row_by_row(columns, sparse, size)
            if rows.cut or self._is_ended(size) or _goes_on(rows.values):
                return rows
            return Rows(rows.values[:-1], cut=True)

    def whole_numbers(self, columns: Sequence[int]) -> Array:
        """As `numbers`; MicrogripperError where the last line was cut off as well."""
        rows = self.numbers(columns)
        if rows.cut:
            raise MicrogripperError(
                f"{self.path}: the last line has no end and looks cut off; complete or remove it"
            )
        return rows.values

    def _row_by_row(self, columns: Sequence[int], sparse: int | None, size: int) -> Rows:
        """As `numbers`, slower, but able to name what is wrong and to leave out what may be."""
        rows: list[list[float]] = []
        cut = False
        with _text(self.path) as file:
            reader = csv.reader(file, delimiter=self.delimiter)
            try:
                next(reader)
                for row in reader:
                    if not any(cell.strip() for cell in row):
                        continue
                    line = reader.line_num
                    self._check_cells(row, f"line {line}", "repair the line")
                    try:
                        rows.append([self._number(row, at, line, sparse) for at in columns])
                    except MicrogripperError:
                        cut = not self._is_ended(size) and next(reader, None) is None
                        if not cut:
                            raise
            except csv.Error as error:
                raise MicrogripperError(f"{self.path}: line {reader.line_num}: {error}") from None
        return Rows(np.array(rows, dtype=float).reshape(len(rows), len(columns)), cut)

    def _number(self, row: list[str], at: int, line: int, sparse: int | None) -> float:
        where = f"{self.path}: line {line}"
        if at >= len(row):
            raise MicrogripperError(
                f"{where}: {len(row)} cells, none in column {self.header[at]!r}; complete or "
                "remove it"
            )
        cell = row[at].strip()
        if not cell and at == sparse:
            return float("nan")
        try:
            return _float(cell)
        except ValueError:
            remedy = f"; {DECIMAL_POINTS}" if "," in cell else ""
            raise MicrogripperError(
                f"{where}: {cell!r:.40} in column {self.header[at]!r} is not a number{remedy}"
            ) from None

    def _check_width(self, usual: str) -> None:
        """Raise MicrogripperError if a row has more cells than names: 5,002 is two of them.

        The first and the last are looked at: one of them may have whole numbers only.
        """
        with _text(self.path) as file:
            reader = csv.reader(file, delimiter=self.delimiter)
            try:
                next(reader)
                first = next((row for row in reader if any(cell.strip() for cell in row)), [])
                last_line = self._end().rstrip("\r\n").rsplit("\n", 1)[-1]
                last = next(csv.reader([last_line], delimiter=self.delimiter), [])
            except csv.Error:
                return  # told where the row is read
            if not all(_is_number(cell or "0") for cell in last):
                last = []  # text with line breaks in it, or a line that was cut off
            for which, row in ((f"line {reader.line_num}", first), ("the last line", last)):
                self._check_cells(row, which, f"line 1 should be such as {usual}")

    def _check_cells(self, row: list[str], which: str, remedy: str) -> None:
        """Raise MicrogripperError where cells of a row that are not empty have no name."""
        if any(cell.strip() for cell in row[len(self.header) :]):
            raise MicrogripperError(
                f"{self.path}: {which}: {len(row)} cells, the header in line 1 has "
                f"{len(self.header)}; {remedy}, and {DECIMAL_POINTS}"
            )

    def _delimiters(self) -> int:
        """How many there are in the file; 0 if it has quotes, between which they are text."""
        mark, count = self.delimiter.encode(), 0
        with self.path.open("rb") as file:
            while piece := file.read(COUNTED_AT_ONCE):
                if b'"' in piece:
                    return 0
                count += piece.count(mark)
        return count

    def _is_ended(self, size: int) -> bool:
        """Whether the last line has its end, and none was begun since the file had `size` bytes."""
        return self.path.stat().st_size == size and self._end().endswith(("\n", "\r"))

    def _end(self) -> str:
        """The last characters of the file."""
        with self.path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - LONGEST_HEADER))
            return file.read().decode("latin-1")


def _text(path: Path) -> TextIO:
    # Only the names of the columns are text: a foreign encoding spoils at most those.
    return path.open(encoding="utf-8-sig", errors="surrogateescape", newline="")


def _western(line: str) -> str:
    """The line as it was meant if it is no UTF-8: in the encoding of Western Europe's Windows."""
    if not any("\udc80" <= character <= "\udcff" for character in line):
        return line
    return line.encode("utf-8", "surrogateescape").decode("cp1252", "replace")


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be read: {error.strerror}") from None


def _goes_on(values: Array) -> bool:
    """Whether the last row is in line with those before it: 4.8e-07 without its end is 4.8."""
    if len(values) < FEW:
        return True
    with np.errstate(over="ignore", invalid="ignore"):  # told by whoever needs finite numbers
        steps = np.abs(np.diff(values, axis=0))
    near = steps[-1] <= LARGEST_STEP * np.fmax.reduce(steps[:-1])
    missing = np.isnan(values[-2:]).all(axis=0)
    return bool(np.all(near | missing))


def _is_number(text: str) -> bool:
    try:
        _float(text)
    except ValueError:
        return False
    return True


def _float(text: str) -> float:
    """The number in a cell; ValueError if it is none: Python alone reads 1_000 as one."""
    if "_" in text:
        raise ValueError(text)
    return float(text)
