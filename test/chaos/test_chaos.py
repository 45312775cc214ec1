"""A small dose of `make chaos`, and its own judgement on voltages made by hand."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from invariants import Invariants
from rounds import ramp_begin

import microgripper_control

ROOT = Path(microgripper_control.__file__).parents[1]
PATIENCE = 300.0  # s


@pytest.mark.ros
def test_a_small_dose_is_survived(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, Path(__file__).parent, "--small"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    print(done.stdout, done.stderr)
    assert done.returncode == 0


@pytest.mark.parametrize(
    ("course", "violations"),
    [
        ([(0.0, 0.0), (0.001, 20.0), (0.002, 0.0)], 0),
        ([(0.0, 0.0), (0.0001, 20.0)], 0),
        ([(0.0, 0.0), (0.001, 20.1)], 1),
        ([(0.0, 0.0), (0.004, 80.1)], 1),
        ([(0.0, 0.0), (1.0, 160.0)], 0),
        ([(0.0, -0.1)], 1),
        ([(0.0, 160.1)], 1),
        ([(0.0, math.nan), (0.1, math.inf)], 2),
    ],
)
def test_what_is_a_violation(course: list[tuple[float, float]], violations: int) -> None:
    invariants = Invariants()
    for at, voltage in course:
        invariants.note(at, voltage)
    assert invariants.violations == violations


def test_where_a_ramp_begins() -> None:
    held = [(1e-3 * k, 50.0 - 0.1 * k) for k in range(60)]
    ramp = [(0.060 + 1e-3 * k, 42.1 - 2.0 * k) for k in range(10)]
    assert ramp_begin(held) is None
    assert ramp_begin([*held, *ramp]) == pytest.approx(0.060)
