"""Our reader and rosbags', which share no code, read the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from microgripper_control.bench.long_bag import write_long_bag
from microgripper_control.core.recording import Recording
from microgripper_control.recordings.bag_writer import STORAGES
from microgripper_control.recordings.one_by_one import read_one_by_one
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.write import write_bag


@pytest.mark.parametrize("storage", STORAGES)
def test_both_readers_agree(tmp_path: Path, storage: str) -> None:
    random = np.random.default_rng(3)
    voltage, displacement = random.uniform(0.0, 100.0, (2, 9000))
    write_bag(tmp_path / "run", Recording("run", 1e-3, voltage, displacement), storage)
    ours = read_recording(tmp_path / "run")
    time, volts, metres = read_one_by_one(tmp_path / "run")
    np.testing.assert_array_equal(ours.voltage, volts)
    np.testing.assert_array_equal(ours.displacement, metres)
    np.testing.assert_allclose(ours.time, time, rtol=0.0, atol=1e-9)


def test_a_long_bag_written_at_once_is_read(tmp_path: Path) -> None:
    write_long_bag(tmp_path / "long.mcap", 150_000)
    found = read_recording(tmp_path / "long.mcap")
    assert not found.warnings
    assert len(found) == 150_000
    np.testing.assert_allclose(found.measured, 1e-7 * found.voltage)
    assert found.voltage[1000] == pytest.approx(50.0 * (1.0 - np.cos(1.0)))
