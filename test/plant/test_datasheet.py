"""config/apa120s_datasheet.yaml has the maker's figures."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.share import share_folder
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import load_model
from microgripper_control.plant.simulate import simulate

MODEL = load_model(share_folder() / "config" / "apa120s_datasheet.yaml")


def test_stroke_and_blocked_force() -> None:
    low, high = MODEL.voltage_range
    assert high - low == 170.0
    there, back = np.linspace(low, high, 2000), np.linspace(high, low, 2000)
    voltage = np.concatenate([np.linspace(0.0, low, 500), *[there, back] * 10])
    bare = MODEL.without(["transport_delay", "sensor_quantization"])
    stroke = np.ptp(simulate(bare, voltage, 1e-3)[-4000:])
    assert stroke == pytest.approx(140e-6, rel=1e-3)
    assert stroke * MODEL.value("second_order", "k") == pytest.approx(46.0, rel=0.01)


def test_resonance_and_damping() -> None:
    mechanics = MODEL.values("second_order")
    stiffness = mechanics["k"] + mechanics["k_s"]
    assert np.sqrt(stiffness / mechanics["m"]) / (2.0 * np.pi) == pytest.approx(1300.0, rel=1e-3)
    paper = nominal_model().values("second_order")

    def damping_ratio(values: dict[str, float]) -> float:
        return float(values["b"] / (2.0 * np.sqrt((values["k"] + values["k_s"]) * values["m"])))

    assert damping_ratio(mechanics) == pytest.approx(damping_ratio(paper), rel=1e-2)


def test_sensor() -> None:
    assert MODEL.value("sensor_quantization", "resolution") == 1e-6
    assert MODEL.value("transport_delay", "delay") == pytest.approx(4.0 / 1500.0, rel=1e-3)
