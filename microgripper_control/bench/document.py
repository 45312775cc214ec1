"""What was measured, as JSON, CSV and the document that keeps the last run."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import asdict
from io import StringIO
from typing import Any

from microgripper_control.bench.numbers import bound, figure, spent
from microgripper_control.bench.row import Line
from microgripper_control.bench.run import ROWS, Bench

SCHEMA = "microgripper-bench/1"
HEADER = ("what", "ours", "against", "theirs", "figure", "goal", "outcome")
INTRODUCTION = """# How fast it is

Written by `make bench`, every number in one run on one machine. Ratios are medians over rounds in
which the contestants took turns, with the quartiles in brackets: times change from second to second
and from machine to machine, ratios much less. The command above each table measures it again, into
a folder of its own.
"""


def cells(line: Line) -> tuple[str, ...]:
    """A line's row, in the order of `HEADER`."""
    return (
        line.what,
        spent(line.ours),
        line.against,
        spent(line.theirs),
        figure(line),
        bound(line),
        line.outcome,
    )


def as_json(bench: Bench) -> dict[str, Any]:
    """Everything, in SI units."""
    rows = {
        name: {
            "title": ROWS[name].title,
            "lines": [asdict(line) | {"outcome": line.outcome} for line in measured.lines],
            "curves": [asdict(curve) for curve in measured.curves],
            "notes": list(measured.notes),
            "skipped": measured.skipped,
            "broken": measured.broken,
        }
        for name, measured in bench.rows.items()
    }
    return {"schema": SCHEMA, "machine": dict(bench.machine), "quick": bench.quick, "rows": rows}


def as_csv(bench: Bench) -> str:
    """The table, one line a figure; times in s."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = ("row", "what", "ours_s", "against", "theirs_s", "figure", "low", "high", "unit")
    writer.writerow((*names, "goal", "outcome"))
    for name, measured in bench.rows.items():
        for x in measured.lines:
            low, median, high = x.figure
            numbers = ("", "", high) if x.below else (median, low, high)
            fixed = (name, x.what, x.ours, x.against, x.theirs, *numbers)
            writer.writerow((*fixed, x.unit, bound(x), x.outcome))
    return text.getvalue()


def as_markdown(bench: Bench, picture: str) -> str:
    """The document; `picture` is the name of the plot beside it."""
    return "\n".join(_paragraphs(bench, picture)) + "\n"


def _paragraphs(bench: Bench, picture: str) -> Iterator[str]:
    yield INTRODUCTION
    yield from (f"- {key}: {value}" for key, value in bench.machine.items())
    missed = len(bench.judged) - bench.met
    told = [f"Of {len(bench.judged)} goals {bench.met} are met and {missed} missed."]
    if bench.measured < len(bench.rows):
        told.append(f"{bench.measured} of {len(bench.rows)} rows could be measured.")
    if bench.quick:
        told.append("A quick run: fewer rounds, smaller sizes.")
    yield f"\n{' '.join(told)}\n"
    yield f"![Each figure in proportion to its goal, and how cost grows]({picture})"
    quick = " --quick" if bench.quick else ""
    for name, measured in bench.rows.items():
        yield f"\n## {ROWS[name].title[0].upper()}{ROWS[name].title[1:]}\n"
        yield f"    microgripper bench --only {name}{quick} --out out/bench-{name}\n"
        if measured.skipped:
            yield f"Not measured: {measured.skipped}."
            continue
        yield f"| {' | '.join(HEADER)} |"
        yield "| :-- | --: | :-- | --: | --: | --: | :-- |"
        yield from (f"| {' | '.join(cells(line))} |" for line in measured.lines)
        yield from (f"\n{note}" for note in measured.notes)
