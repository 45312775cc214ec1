"""Plant, controller, reference and recorder together, in lockstep."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from running_nodes import PATIENCE, Start

from microgripper_control.control.setpoints import Sine
from microgripper_control.core.recording import Recording
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import save_model
from microgripper_control.recordings.read import read_recording

pytestmark = pytest.mark.ros

WAVE = {"shape": "sine", "low": 3e-6, "high": 15e-6, "frequency": 1.0}


def experiment(
    start: Start, out: Path, length: float, *, reference_last: bool = False, **plant: object
) -> Recording:
    """Record a run from its first sample to its last."""
    recorder = start("recorder", out=str(out))
    lockstep = {"lockstep": True, "lockstep_timeout": PATIENCE}
    controller = start("controller", partners=["plant_simulator", "recorder"], **lockstep)
    partners = ["controller", "reference", "recorder"]
    simulator = start("plant_simulator", partners=partners, duration=length, **lockstep, **plant)
    if reference_last:
        controller.until_it_says("waiting for a publisher of setpoints")
    reference = start(
        "reference", partners=["controller", "recorder"], at_end="stop", length=length, **WAVE
    )
    assert simulator.ended() == 0
    assert reference.ended() == 0
    assert controller.stop() == 0
    assert recorder.stop() == 0
    return read_recording(out)


def test_two_runs_with_one_seed_are_the_same_to_the_bit(start: Start, tmp_path: Path) -> None:
    first = experiment(start, tmp_path / "first", 1.5, seed=5)
    again = experiment(start, tmp_path / "again", 1.5, seed=5)
    assert first.warnings == ()
    assert len(first) == len(again) == 1500
    assert (first.start, first.sample_period) == (0.0, 0.001)
    for quantity in ("voltage", "displacement", "setpoint"):
        np.testing.assert_array_equal(getattr(first, quantity), getattr(again, quantity))
    # Each setpoint is the one of its sample.
    wanted = Sine(low=3e-6, high=15e-6, frequency=1.0).samples(1500, 0.001)
    np.testing.assert_array_equal(first.setpoint, wanted)


def test_the_cascade_tracks_a_plant_that_is_not_quite_its_model(
    start: Start, tmp_path: Path
) -> None:
    nominal = nominal_model()
    factors = {
        "bouc_wen": {"d": 0.9, "alpha": 1.1, "beta": 0.9, "gamma": 1.1},
        "second_order": {"m": 1.1, "b": 0.9, "k": 1.1, "k_s": 0.9},
    }
    off = {
        (link, name): factor * nominal.value(link, name)
        for link, own in factors.items()
        for name, factor in own.items()
    }
    save_model(nominal.with_values(off), tmp_path / "off.yaml")
    run = experiment(
        start,
        tmp_path / "bag",
        3.0,
        reference_last=True,
        model_file=str(tmp_path / "off.yaml"),
    )
    assert run.setpoint is not None
    error = (run.measured - run.setpoint)[1000:]
    assert np.sqrt(np.mean(error**2)) < 0.002 * np.ptp(run.setpoint)
