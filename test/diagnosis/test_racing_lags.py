"""A lag is not given up while another one is ahead."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.diagnose import candidate_names, diagnose
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD, COUNT, NOISE = 5e-4, 5000, 2.6e-8
BESSEL = {"lag": 1.06e-3, "curvature": 0.4775, "third": 0.4306}  # of third order
SECOND = {"averaging": 5e-4, "time_constant": 8e-4, "curvature": 0.36}


def steps(seed: int) -> Array:
    """Levels at random, V, each held for 30 to 120 ms."""
    generator = np.random.default_rng(seed)
    held = generator.integers(60, 240, COUNT // 60 + 1)
    return np.repeat(generator.uniform(5.0, 150.0, len(held)), held)[:COUNT]


def chirp(fastest: float) -> Array:
    """Up to so many Hz, V."""
    time = PERIOD * np.arange(COUNT)
    return 75.0 - 60.0 * np.cos(2.0 * np.pi * (time + 0.5 * (fastest - 1.0) * time**2 / time[-1]))


@pytest.mark.parametrize(("lag", "values"), [("amplifier_lag", BESSEL), ("sensor_lag", SECOND)])
def test_a_lag_is_not_taken_for_another(lag: str, values: dict[str, float]) -> None:
    """What a refit without any makes up for leads the fits of all of them astray."""
    base = {("bouc_wen", "d"): 1.33e-7, ("bouc_wen", "alpha"): 0.071, ("bouc_wen", "gamma"): -0.021}
    rig = nominal_model().with_values(base).with_link(lag, **values)
    recordings = []
    for name, voltage in (("fast", chirp(200.0)), ("slow", chirp(60.0)), ("steps", steps(3))):
        noise = NOISE * np.random.default_rng(len(recordings)).standard_normal(COUNT)
        measured = simulate(rig, voltage, PERIOD) + noise
        recordings.append(Recording(name, PERIOD, voltage, measured))
    others = set(candidate_names()) - {"amplifier_lag", "sensor_lag"}
    conditions = Conditions(initial=Initial.REST)
    found = diagnose(nominal_model(), recordings[:2], recordings[2:], conditions, without=others)
    assert found.effects == (lag,)
    assert found.gap.augmented < 1.02 * NOISE
