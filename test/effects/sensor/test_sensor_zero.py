"""The zero of the sensor is added to what it reads, and to nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate


@pytest.mark.parametrize("hold", list(Hold))
@pytest.mark.parametrize("offset", [3e-6, -0.5])
def test_it_is_added(paper: Model, lively: Array, hold: Hold, offset: float) -> None:
    found = simulate(paper.with_link("sensor_zero", offset=offset), lively, 1e-3, hold=hold)
    np.testing.assert_array_equal(found, simulate(paper, lively, 1e-3, hold=hold) + offset)


def test_it_is_what_a_sensor_counts_from(paper: Model, lively: Array) -> None:
    """The zero comes before the resolution: the multiples do not move with it."""
    model = paper.with_link("sensor_zero", offset=0.3e-6).with_link("sensor_quantization")
    steps = simulate(model, lively, 1e-3) / 1e-6
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)


def test_a_planted_zero_is_seen(paper: Model, lively: Array) -> None:
    """It is the one thing in a recording that moves its mean and nothing else."""
    rig = paper.with_link("sensor_zero", offset=-2e-6)
    noise = 15e-9 * np.random.default_rng(0).normal(size=len(lively))
    error = simulate(rig, lively, 1e-3) + noise - simulate(paper, lively, 1e-3)
    assert np.mean(error) == pytest.approx(-2e-6, abs=4.0 * 15e-9 / np.sqrt(len(lively)))
