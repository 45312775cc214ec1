"""The table, the files and the plot of a benchmark."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from microgripper_control.bench.document import as_csv, as_json, as_markdown
from microgripper_control.bench.machine import machine
from microgripper_control.bench.numbers import bound, figure, seconds
from microgripper_control.bench.row import (
    MET,
    MISSED,
    Curve,
    Effort,
    Line,
    Measured,
    Row,
    at_least,
    at_most,
)
from microgripper_control.bench.run import ROWS, Bench, run
from microgripper_control.bench.timing import Spread
from microgripper_control.cli.main import app
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.report.bench_figure import FEW, MANY, draw_bench, margin

FAST = Line("simulating", "C", Spread(0.8, 0.9, 1.0), "times as fast", at_least(0.8), 9e-9, 8.1e-9)
SLOW = Line("start", "", Spread(1.1, 1.2, 1.3), "s", at_most(1.0))
CURVE = Curve("reading", "samples", (10.0, 100.0), (1e-3, 1e-2), "s")


@pytest.fixture
def bench() -> Bench:
    rows = {
        "simulation": Measured((FAST, SLOW), ("As it was measured.",), (CURVE,)),
        "loop": Measured(skipped="ROS 2 is not there"),
    }
    return Bench({"processor": "a test"}, rows, quick=False)


@pytest.mark.parametrize(
    ("value", "text"), [(1.5, "1.5 s"), (0.0032, "3.2 ms"), (1.5e-6, "1.5 µs"), (0.0, "0 ns")]
)
def test_a_time_has_the_unit_that_suits_it(value: float, text: str) -> None:
    assert seconds(value) == text


def test_goals_are_met_or_missed() -> None:
    assert (FAST.outcome, SLOW.outcome) == (MET, MISSED)
    assert (figure(FAST), bound(FAST)) == (
        "0.9 times as fast [0.8, 1]",
        "at least 0.8 times as fast",
    )
    assert bound(SLOW) == "at most 1 s"
    nothing = Line("x", "", Spread.single(np.nan), "s", at_most(1.0))
    assert nothing.outcome == MISSED


def test_the_margin_is_how_much_better_than_the_goal() -> None:
    assert margin(FAST) == pytest.approx(0.9 / 0.8)
    assert margin(SLOW) == pytest.approx(1.0 / 1.2)
    assert margin(Line("x", "", Spread.single(0.0), "%", at_most(0.1))) == MANY
    assert margin(Line("x", "", Spread.single(0.0), "x", at_least(2.0))) == FEW


def test_the_document_names_command_machine_and_misses(bench: Bench) -> None:
    text = as_markdown(bench, "performance.png")
    assert "Of 2 goals 1 are met and 1 missed." in text
    assert "| start |  |  |  | 1.2 s | at most 1 s | missed |" in text
    assert "- processor: a test" in text
    assert "Not measured: ROS 2 is not there." in text
    assert "As it was measured." in text


def test_the_command_of_a_row_leaves_the_others_alone(bench: Bench) -> None:
    text = as_markdown(bench, "performance.png")
    assert "    microgripper bench --only simulation --out out/bench-simulation\n" in text
    assert "--out out/bench\n" not in text


def test_the_document_says_how_many_rows_were_measured(bench: Bench) -> None:
    assert "1 missed. 1 of 2 rows could be measured.\n" in as_markdown(bench, "performance.png")
    whole = Bench({}, {"simulation": bench.rows["simulation"]}, quick=False)
    assert "1 missed.\n" in as_markdown(whole, "performance.png")


def test_files_hold_the_same(bench: Bench) -> None:
    content = json.loads(json.dumps(as_json(bench)))
    assert content["schema"] == "microgripper-bench/1"
    lines = content["rows"]["simulation"]["lines"]
    assert lines[0]["figure"] == [0.8, 0.9, 1.0]
    table = list(csv.DictReader(io.StringIO(as_csv(bench))))
    assert [row["outcome"] for row in table] == [line["outcome"] for line in lines]
    assert float(table[0]["figure"]) == 0.9


def test_a_bound_that_was_not_reached_is_no_figure() -> None:
    slower = Line("rate", "tried 1000 Hz", Spread.single(1000.0), "Hz", below=True)
    bench = Bench({}, {"loop": Measured((slower,))}, quick=False)
    assert "| below 1 000 Hz |" in as_markdown(bench, "performance.png")
    (row,) = csv.DictReader(io.StringIO(as_csv(bench)))
    assert (row["figure"], row["low"], row["high"]) == ("", "", "1000.0")


def test_the_plot_is_drawn(bench: Bench, tmp_path: Path) -> None:
    draw_bench(tmp_path / "performance.png", bench)
    assert (tmp_path / "performance.png").stat().st_size > 10_000


def test_the_machine_is_told() -> None:
    told = machine()
    assert "cores" in told["processor"]
    assert told["numpy"] == np.__version__


def test_an_unknown_row_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MicrogripperError, match="no row 'speed'; known are simulation, effects"):
        run(Effort(tmp_path), ["speed"])


def test_a_row_that_cannot_be_measured_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    measured = run(Effort(tmp_path, quick=True), ["startup"]).rows["startup"]
    assert measured.skipped == "ROS 2 is not there"


def test_a_row_that_breaks_does_not_cost_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(effort: Effort) -> Measured:
        raise ValueError("one\nof two")

    rows = {"a": Row("a", "a", broken), "b": Row("b", "b", lambda effort: Measured((FAST,)))}
    monkeypatch.setattr("microgripper_control.bench.run.ROWS", rows)
    found = run(Effort(tmp_path)).rows
    assert found["a"].skipped == r"ValueError: one\nof two"
    assert found["b"].lines == (FAST,)
    assert (found["a"].broken, found["b"].broken) == (True, False)


@pytest.mark.parametrize("options", [[], ["--json"]])
def test_the_command_fails_where_a_row_breaks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str]
) -> None:
    def broken(effort: Effort) -> Measured:
        raise ValueError("a mistake")

    def lacking(effort: Effort) -> Measured:
        raise MicrogripperError("ROS 2 is not there")

    rows = {
        "streaming": Row("streaming", "a", lambda effort: Measured((FAST,))),
        "loop": Row("loop", "b", lacking),
        "startup": Row("startup", "c", broken),
    }
    monkeypatch.setattr("microgripper_control.bench.run.ROWS", rows)
    given = ["bench", "--out", str(tmp_path), *options]
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 1
    assert (tmp_path / "bench.csv").exists()
    if not options:
        assert "1 of 1 goals met; 1 of 3 rows measured, 1 failed" in result.output
    del rows["startup"]
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 0


def test_every_row_has_a_name_of_its_own() -> None:
    assert len(ROWS) == 10
    assert all(row.name == name and row.title for name, row in ROWS.items())


def test_the_command_writes_its_files(tmp_path: Path) -> None:
    given = ["bench", "--quick", "--only", "streaming", "--out", str(tmp_path)]
    result = CliRunner().invoke(app, given, catch_exceptions=False)
    assert result.exit_code == 0
    names = {"performance.md", "performance.png", "bench.csv", "bench.json"}
    assert {file.name for file in tmp_path.iterdir()} == names
    assert "goals met" in result.output
