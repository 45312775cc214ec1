"""An examination runs through subprocesses, goes on where it stopped, and seals the truth."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path

import pytest
from hand_made import diagnosis

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder
from microgripper_control.core.folder_lock import FolderLock
from microgripper_control.diagnosis.diagnose import candidate_names
from microgripper_control.examination import asking
from microgripper_control.examination import run as running
from microgripper_control.examination.asking import ANSWERED, FAILED, LATE, UNMADE, Asked, ask
from microgripper_control.examination.beside.compare import METHODS, compare
from microgripper_control.examination.folder import Folder
from microgripper_control.examination.plan import Planned
from microgripper_control.examination.score import score
from microgripper_control.examination.sources import sources
from microgripper_control.validation.case import make_case
from microgripper_control.validation.case_files import write_case

SMALL = 8274  # a development seed with few samples
TRIED = ("creep", "sensor_lag")
LEFT_OUT = tuple(name for name in candidate_names() if name not in TRIED)


def blank(number: int, verdict: str = "none") -> Planned:
    return Planned(number, "blind", (verdict,), "a", "medium", "loops", SMALL + number)


@pytest.fixture
def quiet(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Cases are made, but answered at once; the names of those that were."""
    asked: list[str] = []

    def answer(case: Path, *rest: object) -> Asked:
        asked.append(case.name)
        return Asked(ANSWERED, 1.0, 1.0, "", diagnosis(("none",)))

    monkeypatch.setattr(running, "ask", answer)
    monkeypatch.setattr(running, "compare", lambda *given: {})
    return asked


def silent(done: int, total: int, left: float | None) -> None:
    pass


def test_a_real_case_from_end_to_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # With a library of two effects, as all of them take their time.
    monkeypatch.setattr(running, "ask", lambda case, to, _, limit: ask(case, to, LEFT_OUT, limit))
    monkeypatch.setattr(running, "compare", lambda case, _: compare(case, LEFT_OUT))
    case = Planned(1, "blind", ("parameters",), "a", "medium", "loops", SMALL)
    (record,) = running.run(tmp_path, [case], silent, jobs=1)
    assert (record.outcome, record.why) == (ANSWERED, "")
    assert record.diagnosis is not None
    entries = {entry["effect"] for entry in record.diagnosis["candidates"]}
    assert entries == {*TRIED, "none", "parameters", "unknown"}
    assert all(
        record.seconds[what] > 0.0 for what in ("making", "diagnosing", "diagnosing_busy", "beside")
    )
    assert set(record.beside) == set(METHODS)
    found = score(Folder(tmp_path), [record])
    assert (found.cases[0].asked, found.cases[0].said) == ("parameters", "parameters")
    given = {path.name for path in (tmp_path / "cases" / "case_001").iterdir()}
    assert given == {"job.json", "model.yaml", "recording_1.csv", "heldout_1.csv"}


def test_an_examination_that_was_stopped_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, quiet: list[str]
) -> None:
    planned = [blank(number) for number in (1, 2, 3)]
    at_once = running.run(tmp_path / "whole", planned, silent, jobs=1)
    quiet.clear()
    answering = running.ask

    def killed(case: Path, *rest: object) -> Asked:
        if len(quiet) == 1:
            raise KeyboardInterrupt
        return answering(case, tmp_path)

    monkeypatch.setattr(running, "ask", killed)
    with pytest.raises(KeyboardInterrupt):
        running.run(tmp_path / "stopped", planned, silent, jobs=1)
    assert quiet == ["case_001"]
    monkeypatch.setattr(running, "ask", answering)
    seen: list[tuple[int, int]] = []
    records = running.run(
        tmp_path / "stopped", planned, lambda done, total, left: seen.append((done, total)), jobs=1
    )
    assert quiet == ["case_001", "case_002", "case_003"]
    assert seen == [(1, 3), (2, 3), (3, 3)]
    assert [r.diagnosis for r in records] == [r.diagnosis for r in at_once]
    for case in planned:
        truths = [Folder(tmp_path / name).seal(case) for name in ("whole", "stopped")]
        assert truths[0].read_bytes() == truths[1].read_bytes()


def test_a_part_may_be_done_first(tmp_path: Path, quiet: list[str]) -> None:
    planned = [blank(number) for number in (1, 2, 3)]
    records = running.run(tmp_path, planned, silent, jobs=1, asked=planned[:2])
    assert quiet == ["case_001", "case_002"]
    assert [record.planned for record in records] == planned[:2]
    assert len(running.run(tmp_path, planned, silent, jobs=1)) == 3
    assert quiet == ["case_001", "case_002", "case_003"]
    assert len(running.run(tmp_path, planned, silent, jobs=1, asked=planned[:1])) == 1


def test_another_examination_is_not_mixed_in(tmp_path: Path, quiet: list[str]) -> None:
    running.run(tmp_path, [blank(1)], silent, jobs=1)
    with pytest.raises(MicrogripperError, match="holds another examination"):
        running.run(tmp_path, [blank(2)], silent, jobs=1)


def test_results_of_other_code_are_not_mixed_in(
    tmp_path: Path, quiet: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    running.run(tmp_path, [blank(1)], silent, jobs=1)
    with monkeypatch.context() as edited:
        edited.setattr("microgripper_control.examination.folder.sources", lambda: "edited")
        with pytest.raises(MicrogripperError, match=f"--out {tmp_path}: was begun by other code"):
            running.run(tmp_path, [blank(1)], silent, jobs=1)
    assert len(running.run(tmp_path, [blank(1)], silent, jobs=1)) == 1


def test_the_sources_are_told_by_a_hash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("microgripper_control.examination.sources.PACKAGE", tmp_path)
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "one.py").write_text("a = 1")
    before = sources()
    assert sources() == before
    (tmp_path / "room" / "one.py").write_text("a = 2")
    assert sources() != before


def test_code_that_is_edited_while_it_runs_ends_it(
    tmp_path: Path, quiet: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    running.run(tmp_path, [blank(1), blank(2)], silent, jobs=1, asked=[blank(1)])
    hashes = iter([Folder(tmp_path).code, *["edited"] * 9])
    monkeypatch.setattr("microgripper_control.examination.folder.sources", lambda: next(hashes))
    with pytest.raises(MicrogripperError, match="was begun by other code"):
        running.run(tmp_path, [blank(1), blank(2)], silent, jobs=1)
    assert not Folder(tmp_path).result(blank(2)).exists()


@pytest.mark.parametrize("at_work", ["results", "answers/case_001"])
def test_two_at_once_are_kept_apart(tmp_path: Path, quiet: list[str], at_work: str) -> None:
    with (
        closing(FolderLock(make_folder(tmp_path / at_work))),
        pytest.raises(MicrogripperError, match="is being written; another examination"),
    ):
        running.run(tmp_path, [blank(1)], silent, jobs=1)
    assert quiet == []
    assert len(running.run(tmp_path, [blank(1)], silent, jobs=1)) == 1


def test_a_case_that_cannot_be_made_is_told_and_not_counted(
    tmp_path: Path, quiet: list[str]
) -> None:
    wrong = Planned(1, "blind", ("creep",), "b", "medium", "loops", SMALL)  # kept for reporting
    (record,) = running.run(tmp_path, [wrong], silent, jobs=1)
    assert (record.outcome, quiet) == (UNMADE, [])
    assert "kept for reporting" in record.why
    found = score(Folder(tmp_path), [record])
    assert len(found.cases) == 0
    assert found.failures == (("case_001", UNMADE, record.why),)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("asked")
    case = make_case("blind", ["none"], "a", "medium", "loops", SMALL)
    write_case(case, root / "case", root / "truth.json")
    return root / "case"


def test_too_late_is_an_outcome(written: Path, tmp_path: Path) -> None:
    asked = ask(written, tmp_path / "answer", limit=1)
    assert (asked.outcome, asked.diagnosis) == (LATE, None)
    assert asked.why == "no answer within 1 s of a processor"
    assert 0.9 <= asked.busy < 2.0


@pytest.mark.parametrize(("pause", "outcome"), [(1.5, ANSWERED), (7.0, LATE)])
def test_waiting_for_a_processor_is_not_being_late_but_hanging_is(
    pause: float,
    outcome: str,
    written: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    slow = tmp_path / "slow"  # its last word is the folder it writes into
    last = 'for last; do :; done; echo {} > "$last/diagnosis.json"'
    slow.write_text(f"#!/bin/sh\nsleep {pause}\n{last}\n")
    slow.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(slow))
    monkeypatch.setattr(asking, "PATIENCE", 4)
    asked = ask(written, tmp_path / "answer", limit=1)
    assert asked.outcome == outcome


def test_a_failure_is_an_outcome_with_its_reason(written: Path, tmp_path: Path) -> None:
    asked = ask(written, tmp_path / "answer", withheld=("no_such_effect",))
    assert asked.outcome == FAILED
    assert "--without no_such_effect: is no effect that is tried" in asked.why


def test_the_diagnosing_process_is_given_nothing_that_tells(written: Path) -> None:
    for path in written.iterdir():
        text = path.read_text(encoding="utf-8")
        assert not any(f'"{word}"' in text for word in ("none", "blind", "seed", "truth"))
    assert set(json.loads((written / "job.json").read_text())) == {
        "model",
        "recordings",
        "heldout",
        "hold",
    }
