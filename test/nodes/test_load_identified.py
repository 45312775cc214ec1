"""What the controller takes from a model file."""

from __future__ import annotations

from pathlib import Path

import pytest

from microgripper_control.control.tuning import default_gains
from microgripper_control.nodes.controller_settings import load_identified
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import save_model


def test_lags_and_modes_of_the_model_lower_the_default_gain(tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    gains = []
    for effects in (
        {},
        {"sensor_lag": {"averaging": 0.0, "time_constant": 4.8e-3}},
        {"extra_resonance": {"share": 0.2, "frequency": 100.0, "damping": 0.02}},
    ):
        model = nominal_model()
        for name, values in effects.items():
            model = model.with_link(name, **values)
        save_model(model, path)
        identified = load_identified(str(path))
        assert identified.dead_time == pytest.approx(model.dead_time)
        assert identified.ringing == pytest.approx(model.ringing)
        gains.append(default_gains(identified, 1e-3).ki)
    plain, lagging, ringing = gains
    assert lagging < 0.5 * plain
    assert ringing < 0.5 * plain
