"""All rows, in the order of the table."""

from __future__ import annotations

import traceback
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from microgripper_control.bench.machine import machine
from microgripper_control.bench.row import MET, Effort, Line, Measured, Row
from microgripper_control.bench.rows import (
    diagnosis,
    effects,
    growth,
    identification,
    lockstep,
    loop,
    reading,
    simulation,
    startup,
    streaming,
)
from microgripper_control.core.errors import MicrogripperError, one_line

ROWS: Mapping[str, Row] = {
    module.ROW.name: module.ROW
    for module in (
        simulation,
        effects,
        streaming,
        identification,
        diagnosis,
        growth,
        reading,
        loop,
        lockstep,
        startup,
    )
}


@dataclass(frozen=True)
class Bench:
    """What was measured, by row, and on what machine."""

    machine: Mapping[str, str]
    rows: Mapping[str, Measured]
    quick: bool

    @property
    def judged(self) -> tuple[Line, ...]:
        """The lines that have a goal."""
        return tuple(line for m in self.rows.values() for line in m.lines if line.goal)

    @property
    def met(self) -> int:
        """How many of them keep to it."""
        return sum(line.outcome == MET for line in self.judged)

    @property
    def measured(self) -> int:
        """How many rows were measured."""
        return sum(not row.skipped for row in self.rows.values())

    @property
    def broken(self) -> int:
        """How many of the others were not by a mistake of ours."""
        return sum(row.broken for row in self.rows.values())


def run(effort: Effort, only: Collection[str] = ()) -> Bench:
    """Measure the rows, or `only` some; MicrogripperError for one that there is not."""
    for name in only:
        if name not in ROWS:
            raise MicrogripperError(f"bench: no row {name!r}; known are {', '.join(ROWS)}")
    where = machine()
    return Bench(where, dict(_measured(effort, only)), effort.quick)


def _measured(effort: Effort, only: Collection[str]) -> Iterator[tuple[str, Measured]]:
    for name, row in ROWS.items():
        if only and name not in only:
            continue
        effort.progress(row.title)
        with TemporaryDirectory(prefix="microgripper_bench_", ignore_cleanup_errors=True) as folder:
            yield name, _tried(row, replace(effort, folder=Path(folder)))


def _tried(row: Row, effort: Effort) -> Measured:
    """What came of a row: one that fails, even by a mistake of ours, does not cost the others."""
    try:
        return row.measure(effort)
    except MicrogripperError as error:
        return Measured(skipped=str(error))
    except Exception as error:
        traceback.print_exc()
        return Measured(skipped=one_line(f"{type(error).__name__}: {error}"), broken=True)
