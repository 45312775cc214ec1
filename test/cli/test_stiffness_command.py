"""`microgripper stiffness` on a user's CSV."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Run = Callable[..., Any]  # as `microgripper` in conftest.py


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """10 N a row at 1e6 N/m with a zero of 3 um; columns in another order, and one more."""
    path = tmp_path / "flexure.csv"
    rows = [f"{1e-5 * k + 3e-6:.9f};x;{10 * k}" for k in range(8)]
    path.write_text("\n".join(["displacement_m;note;force_N", *rows]), encoding="utf-8")
    return path


def test_the_stiffness_of_a_csv(microgripper: Run, data: Path) -> None:
    outcome = microgripper("stiffness", data)
    assert outcome.status == 0
    assert outcome.out.startswith("stiffness 1e+06 N/m")
    found = json.loads(microgripper("stiffness", data, "--json").out)
    assert found["schema"] == "microgripper-stiffness/1"
    assert found["value"] == pytest.approx(1e6, rel=1e-6)
    assert found["offset"] == pytest.approx(3e-6, abs=1e-12)
    assert found["points"] == 8


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "is empty; expected a header such as force_N,displacement_m"),
        (
            "force_N,displacement_m\n" + "\n".join([*["1,2"] * 12, "1,900"]),
            "the last line has no end and looks cut off",
        ),
        ("force,displacement_m\n1,2\n", "no columns named 'force_N'"),
        ("force_N,displacement_m\n1,a\n", "'a' in column 'displacement_m' is not a number"),
        ("force_N,displacement_m\n1,2\n2,3\n", "at least 3 pairs"),
        (
            "force_N,displacement_m\n0,0\n1e200,1e200\n2e300,2e300\n",
            "bad.csv: the largest force is 2e+300 N, outside 1e-50 .. 1e+50 N; check the unit",
        ),
        ("force_N,displacement_m\n0,0\n1e-200,1e-200\n2e-200,2e-200\n", "is 2e-200 N, outside"),
    ],
)
def test_bad_data_get_one_line_and_status_2(
    microgripper: Run, tmp_path: Path, content: str, says: str
) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(content, encoding="utf-8")
    outcome = microgripper("stiffness", path)
    assert outcome.status == 2
    assert says in outcome.err
    assert outcome.err.count("\n") == 1
