from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rcl_interfaces.srv import GetParameters
from running_nodes import PATIENCE, Start, Watcher

from microgripper_control.core.recording import Recording
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import load_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.write import write_bag

pytestmark = pytest.mark.ros

TRUTH = {("bouc_wen", "d"): 1.52e-7, ("bouc_wen", "alpha"): 0.09}


def test_it_finds_the_model_and_hands_it_to_the_controller(
    start: Start, watcher: Watcher, tmp_path: Path
) -> None:
    rig = nominal_model().with_values(TRUTH)
    time = np.arange(6000) * 1e-3
    voltage = 70.0 - 70.0 * np.cos(2.0 * np.pi * time) * np.linspace(1.0, 0.4, 6000)
    voltage -= voltage[0]
    displacement = simulate(rig, voltage, 1e-3)
    displacement += np.random.default_rng(3).normal(0.0, 1e-9, len(time))
    write_bag(tmp_path / "bag", Recording("made", 1e-3, voltage, displacement))

    controller = start("controller")
    identifier = start(
        "identifier",
        recordings=["bag"],
        out="found.yaml",
        controller="controller",
        timeout=PATIENCE,
    )
    assert identifier.ended() == 0
    found = load_model(tmp_path / "found.yaml")
    for key, value in TRUTH.items():
        assert found.value(*key) == pytest.approx(value, rel=0.01)
    assert "second_order.m is not determined" in identifier.log
    request = GetParameters.Request(names=["model_file"])
    (value,) = watcher.call(GetParameters, "controller/get_parameters", request).values
    assert value.string_value == str(tmp_path / "found.yaml")
    assert controller.stop() == 0


def test_a_controller_that_is_not_there_is_an_error(start: Start, tmp_path: Path) -> None:
    voltage = 50.0 - 50.0 * np.cos(2.0 * np.pi * np.arange(2000) * 1e-3)
    write_bag(
        tmp_path / "bag",
        Recording("made", 1e-3, voltage, simulate(nominal_model(), voltage, 1e-3)),
    )
    identifier = start(
        "identifier", recordings=["bag"], out="found.yaml", controller="controller", timeout=0.5
    )
    assert identifier.ended() == 1
    assert "controller did not answer within 0.5 s" in identifier.log


def test_a_signal_ends_it_while_it_identifies(start: Start, tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    voltage = np.cumsum(rng.normal(0.0, 0.3, 400_000))
    voltage = 75.0 + 70.0 * np.sin(voltage / 40.0)
    displacement = simulate(nominal_model().with_values(TRUTH), voltage, 1e-3)
    displacement += rng.normal(0.0, 1e-8, len(voltage))
    write_bag(tmp_path / "bag", Recording("made", 1e-3, voltage, displacement))
    identifier = start("identifier", recordings=["bag"], out="found.yaml")
    identifier.until_it_says("identifying: simplex")
    assert identifier.stop() == 0
    assert "written" not in identifier.log
    assert not (tmp_path / "found.yaml").exists()
