"""`microgripper validate`: what it writes and prints."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from microgripper_control.cli import validate
from microgripper_control.examination import run as running
from microgripper_control.examination.asking import ANSWERED, Asked
from microgripper_control.examination.plan import Planned

STAGES = dict.fromkeys(("drive", "material", "mechanics", "transmission", "sensor"), 0.0)
NONE = {
    "verdict": "none",
    "effects": [],
    "candidates": [
        {
            "effect": "none",
            "stage": None,
            "probability": 1.0,
            "present": 1.0,
            "heldout_rmse_m": 1e-8,
        }
    ],
    "stages": STAGES,
    "gap": {
        "nominal_rmse_m": 1e-8,
        "refit_rmse_m": 1e-8,
        "augmented_rmse_m": 1e-8,
        "noise_floor_m": 1e-8,
        "free_form_fraction": 0.0,
    },
    "where": [],
    "ambiguous": [],
}


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two small blanks, of which the second gets no good answer."""
    cases = [
        Planned(i + 1, "blind", (what,), "a", "medium", "loops", 8274 + i)
        for i, what in enumerate(("none", "parameters"))
    ]
    monkeypatch.setattr(validate, "plan", lambda seed, quick: cases)
    monkeypatch.setattr(running, "ask", lambda *given: Asked(ANSWERED, 1.0, 1.0, "", NONE))
    monkeypatch.setattr(running, "compare", lambda *given: {})


def test_it_writes_a_page_and_json_and_prints_the_demands(
    microgripper: Callable[..., Any], tmp_path: Path
) -> None:
    ran = microgripper("validate", "--out", tmp_path, "--quick", "--jobs", 1)
    assert ran.status == 0
    assert "too few cases" in ran.out
    assert "parameters taken for none (case_002)" in ran.out
    assert "2 of 2 cases" in ran.err
    assert (tmp_path / "validation.html").exists()
    content = json.loads((tmp_path / "validation.json").read_text())
    assert content["schema"] == "microgripper-validation/1"
    assert [case["right"] for case in content["cases"]] == [True, False]


@pytest.mark.parametrize(("seed", "warned"), [(1, True), (90_000, False)])
def test_a_seed_that_was_learned_from_is_not_passed_off_as_fresh(
    microgripper: Callable[..., Any], tmp_path: Path, seed: int, warned: bool
) -> None:
    ran = microgripper("validate", "--out", tmp_path, "--quick", "--seed", seed, "--jobs", 1)
    assert ("were learned from" in ran.err) is warned
    assert ("were learned from" in (tmp_path / "validation.html").read_text()) is warned
    content = json.loads((tmp_path / "validation.json").read_text())
    assert content["seed_used_in_development"] is warned


def test_the_page_says_how_to_repeat_a_part(
    microgripper: Callable[..., Any], tmp_path: Path
) -> None:
    ran = microgripper(
        "validate", "--out", tmp_path, "--quick", "--seed", 7, "--first", 1, "--jobs", 1
    )
    assert "1 of 1 cases" in ran.err
    asked = ("seed", "quick", "first", "cases_done")
    content = json.loads((tmp_path / "validation.json").read_text())
    assert [content[key] for key in asked] == [7, True, 1, 1]
    page = (tmp_path / "validation.html").read_text()
    command = re.search(r"repeat it with microgripper (.*? --out DIR)\.", page)
    assert command is not None
    ran = microgripper(*command[1].replace("DIR", str(tmp_path / "again")).split(), "--jobs", 1)
    assert ran.status == 0
    again = json.loads((tmp_path / "again" / "validation.json").read_text())
    assert [again[key] for key in asked] == [7, True, 1, 1]
    ran = microgripper(
        "validate", "--out", tmp_path, "--quick", "--seed", 7, "--only", "blanks", "--jobs", 1
    )
    assert "2 of 2 cases" in ran.err
    assert "the blanks of a quick examination" in (tmp_path / "validation.html").read_text()


def test_json_is_the_file_s(microgripper: Callable[..., Any], tmp_path: Path) -> None:
    ran = microgripper("validate", "--out", tmp_path, "--json", "--jobs", 1)
    assert json.loads(ran.out) == json.loads((tmp_path / "validation.json").read_text())


def test_another_seed_does_not_mix_in(
    microgripper: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    microgripper("validate", "--out", tmp_path, "--jobs", 1)
    other = [Planned(1, "blind", ("none",), "a", "medium", "loops", 8300)]
    monkeypatch.setattr(validate, "plan", lambda seed, quick: other)
    ran = microgripper("validate", "--out", tmp_path, "--seed", 2, "--jobs", 1)
    assert ran.status == 2
    assert ran.err.strip().endswith("give another folder or remove this one")
