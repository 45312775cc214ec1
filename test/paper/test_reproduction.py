"""The whole reproduction: what it must find, its report, and docs/paper.md."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from microgripper_control.cli.main import app
from microgripper_control.paper import headline, pid
from microgripper_control.paper import reproduction as module
from microgripper_control.paper.agreement import Kind, Row, summary
from microgripper_control.paper.identification import GAIN
from microgripper_control.paper.reproduction import Reproduction
from microgripper_control.report.paper_chapters import CHAPTERS, chapters
from microgripper_control.report.paper_page import markdown

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "paper.md"
REFRESH = "docs/paper.md is stale: make paper && cp out/paper/paper.md docs/paper.md"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]\d+)?(?![\w.]*\w)")
SAME = 0.03  # relative; a loop through a quantising sensor repeats only so well elsewhere


def split(text: str) -> tuple[str, list[str]]:
    """The text without its numbers, and the numbers as they are written."""
    return NUMBER.sub("#", text), NUMBER.findall(text)


def differs(one: str, other: str) -> bool:
    """Whether two numbers are further apart than rounding elsewhere may bring them."""
    a, b = float(one), float(other)
    if one.isdigit() and a < 100.0:  # of a figure, a table, a count
        return one != other
    mantissa, _, exponent = one.partition("e")
    decimals = len(mantissa.partition(".")[2])
    last_digit = 10.0 ** (int(exponent or 0) - decimals)
    return abs(a - b) > SAME * max(abs(a), abs(b)) + 1.5 * last_digit


def test_the_document_is_what_the_command_writes(reproduction: Reproduction) -> None:
    assert DOCUMENT.is_file(), REFRESH
    here, there = (
        split(text) for text in (markdown(reproduction), DOCUMENT.read_text(encoding="utf-8"))
    )
    assert here[0] == there[0], REFRESH
    stale = [pair for pair in zip(here[1], there[1], strict=True) if differs(*pair)]
    assert stale == [], REFRESH


@pytest.mark.parametrize(
    ("one", "other", "stale"),
    [
        ("7.013e+09", "7.276e+09", True),
        ("1.421e-07", "1.422e-07", False),
        ("1.421e-07", "1.621e-07", True),
        ("0.000", "0.001", False),
        ("0.000", "0.010", True),
        ("-0.533", "-0.553", True),
        ("4", "5", True),
        ("4.130", "4.200", False),
        ("4.130", "4.300", True),
    ],
)
def test_stale_numbers_are_told_from_rounding(one: str, other: str, stale: bool) -> None:
    assert split(f"| {one} V, k1 |") == ("| # V, k1 |", [one])
    assert differs(one, other) is stale


def test_differences_are_relative_to_the_printed_value() -> None:
    assert Row("1", "x", "V", 1.1, 1.0).difference == pytest.approx(0.1)
    assert Row("1", "x", "V", -1.1, -1.0).cells[5] == "+10.00 %"
    assert Row("1", "x", "V", 1.0 - 1e-9, 1.0).cells[5] == "+0.00 %"
    assert Row("1", "x", "V", 1.0).difference is None
    assert Row("1", "x", "V", 1.0).cells[3] == "-"


def bound(ours: float, paper: float | None = 5.0) -> Row:
    return Row("1", "x", "V", ours, paper, form=".1f", kind=Kind.BOUND)


def test_a_bound_is_kept_or_broken_and_has_no_difference() -> None:
    assert bound(1.0).cells[3:6] == ("<\N{NO-BREAK SPACE}5.0", "1.0", "kept")
    assert bound(5.0).cells[3:6] == ("<\N{NO-BREAK SPACE}5.0", "5.0", "broken")
    assert bound(1.0, None).cells[3:6] == ("-", "1.0", "-")
    assert bound(1.0).difference is None


def test_what_was_planted_and_bounds_do_not_count_as_results() -> None:
    rows = [
        *(Row("1", "x", "V", ours, 1.0) for ours in (1.0, 0.99, 1.03, 2.0)),
        *(Row("1", "x", "V", ours, 1.0, kind=Kind.PLANTED) for ours in (1.0, 0.985)),
        *(bound(ours) for ours in (1.0, 2.0, 6.0)),
        Row("1", "x", "V", 1.0),
    ]
    assert summary(rows) == (
        "10 quantities. Of 4 printed results 2 are within 2 %, of 3 printed bounds 2 are kept; "
        "2 values that were planted come back, the farthest 1.5 % off"
    )


def test_planted_are_table_1_and_the_flexure_s_stiffness(reproduction: Reproduction) -> None:
    kinds = Counter(row.kind for row in reproduction.rows() if row.paper is not None)
    assert kinds == {Kind.RESULT: 21, Kind.PLANTED: 13, Kind.BOUND: 6}


def test_table_1_means_what_is_known_of_it(reproduction: Reproduction) -> None:
    found = reproduction.behaviour
    assert found.stroke == pytest.approx(19.2e-6, rel=5e-3)
    assert found.first_width == pytest.approx(0.088, abs=1e-3)
    assert found.settled_width == pytest.approx(0.043, abs=1e-3)
    assert found.left == pytest.approx((1.5e-6, 1.9e-6), abs=0.05e-6)
    assert 0.0 < found.counter_motion < 1e-9


def test_table_1_comes_back_and_the_intervals_hold_it(reproduction: Reproduction) -> None:
    found = reproduction.identification
    for experiment, most in ((found.exact, 1e-9), (found.noisy, 2.5e-3), (found.paper, 0.03)):
        for name, true in found.true_values().items():
            setting = experiment.settings()[name]
            assert setting.value == pytest.approx(true, rel=most)
            if experiment is not found.exact:  # there the intervals are those of rounding
                assert setting.interval is not None
                assert setting.interval[0] <= true <= setting.interval[1]
    assert found.true_values()[GAIN] == pytest.approx(1.4447e-7 * 5e7 / (5e7 + 8.2e5))
    unseen = {entry.key[1] for entry in found.paper.fit.undetermined}
    assert unseen == {"m", "b", "k", "k_s"}


def test_k1_is_the_printed_one_and_the_slope_is_near_one(reproduction: Reproduction) -> None:
    assert reproduction.linearised.fit.found.k1 == pytest.approx(2.3e-8, rel=0.01)
    low, high = reproduction.linearised.frequency_range
    assert 0.2 < low < 0.26 < high < 0.4
    ways = reproduction.open_loop.ways
    assert ways["linearised model"].slope == pytest.approx(1.0, abs=0.03)
    assert ways["exact inverse"].slope == pytest.approx(1.0, abs=1e-6)


def test_the_resolution_alone_moves_the_inverse_towards_table_2(
    reproduction: Reproduction,
) -> None:
    found = reproduction.inverse
    for name, printed in (("alpha", 0.0877), ("beta", 0.0147), ("gamma", -0.0205)):
        assert found.paper.values[name] == pytest.approx(printed, rel=0.1)
        moved = found.paper.values[name] - found.forward[name]
        assert moved * (printed - found.forward[name]) > 0.0


def test_the_optimised_gains_are_better_and_keep_their_margins(
    reproduction: Reproduction,
) -> None:
    sets = reproduction.pid.sets
    for name in (pid.REACTION_SAMPLED, pid.ULTIMATE):
        assert sets[name].tracking is None
    by_rule, optimised, robust = (
        sets[name].tracking for name in (pid.ULTIMATE_PI, pid.OPTIMISED, pid.ROBUST)
    )
    assert by_rule is not None
    assert optimised is not None
    assert robust is not None
    assert optimised.rms <= robust.rms + 1e-3 < by_rule.rms
    assert sets[pid.ROBUST].sampled.gain >= 1.99
    assert sets[pid.ROBUST].sampled.phase >= 44.9


def test_the_cascade_stays_below_5_per_cent_and_beats_its_parts(
    reproduction: Reproduction,
) -> None:
    found = reproduction.headline.errors[headline.MAIN]
    for case in headline.CASES:
        assert found[case][headline.CASCADE].largest < 5.0
    off = found[headline.OFF]
    assert off[headline.CASCADE].rms <= 0.2
    assert off[headline.CASCADE].rms < off[headline.PID].rms < off[headline.FEEDFORWARD].rms
    assert off[headline.FEEDFORWARD].rms < off[headline.NONE].rms


@pytest.fixture(scope="module")
def report(
    reproduction: Reproduction, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, str]:
    """The folder that the command writes and what it prints, the computation being done."""
    folder = tmp_path_factory.mktemp("paper")

    def done(progress: Callable[[str], None]) -> Reproduction:
        return reproduction

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "reproduce", done)
        result = CliRunner().invoke(app, ["paper", "--out", str(folder), "--json"])
    assert result.exit_code == 0
    return folder, result.stdout


def test_the_report_is_whole(reproduction: Reproduction, report: tuple[Path, str]) -> None:
    folder, printed = report
    drawings = [drawing for chapter in chapters(reproduction) for drawing in chapter.drawings]
    assert len(chapters(reproduction)) == CHAPTERS
    expected = {f"{drawing.name}.png" for drawing in drawings} | {"paper.html", "paper.md"}
    assert {path.name for path in folder.iterdir()} == expected
    page = (folder / "paper.html").read_text(encoding="utf-8")
    assert page.count("<img ") == len(drawings)
    for chapter in chapters(reproduction):
        assert f"<h2>{chapter.title.replace(chr(34), '&quot;')}</h2>" in page
    content = json.loads(printed)
    assert content["schema"] == "microgripper-paper/1"
    assert len(content["rows"]) == len(reproduction.rows())
    bounds = [row for row in content["rows"] if row["kind"] == "bound"]
    assert {row["relative_difference"] for row in bounds} == {None}
    assert {row["bound_kept"] for row in bounds} == {True, False}
    assert content["page"] == str(folder / "paper.html")


def test_a_folder_that_cannot_be_made_is_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = CliRunner().invoke(app, ["paper", "--out", str(tmp_path / "file" / "out")])
    assert "cannot be made" in str(result.exception)
