"""The two pairs of nodes that are compared answer each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from microgripper_control.bench.loops import BARE, OURS, run_loop
from microgripper_control.bench.row import Effort
from microgripper_control.bench.rows.lockstep import over_dds


@pytest.mark.ros
@pytest.mark.parametrize("pair", [OURS, BARE], ids=["ours", "bare"])
def test_samples_are_answered(tmp_path: Path, pair: tuple[str, str]) -> None:
    found = run_loop(tmp_path, pair, duration=1.0, rate=100.0, settings={"executor": "events"})
    assert len(found.round_trips) > 20
    assert np.all(found.round_trips > 0.0)
    assert 0.0 <= found.missed < 1.0


@pytest.mark.ros
@pytest.mark.parametrize("beside", [False, True])
def test_lockstep_tells_its_speed(tmp_path: Path, beside: bool) -> None:
    assert over_dds(Effort(tmp_path), duration=0.2, beside=beside) > 0.0
