"""Finite resolution: whole multiples, nearest to the truth."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate


@pytest.mark.parametrize("resolution", [1e-6, 3.7e-8])
def test_readings_are_the_nearest_multiples(paper: Model, lively: Array, resolution: float) -> None:
    shown = simulate(paper.with_link("sensor_quantization", resolution=resolution), lively, 1e-3)
    true = simulate(paper, lively, 1e-3)
    steps = shown / resolution
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
    assert np.max(np.abs(shown - true)) <= 0.5 * resolution * (1.0 + 1e-9)
    assert len(np.unique(np.rint(steps))) > 10


def test_fine_against_the_motion_it_is_noise_of_a_twelfth(paper: Model, lively: Array) -> None:
    shown = simulate(paper.with_link("sensor_quantization", resolution=1e-8), lively, 1e-3)
    error = (shown - simulate(paper, lively, 1e-3))[:400]
    assert np.std(error) == pytest.approx(1e-8 / np.sqrt(12.0), rel=0.1)


def test_it_comes_behind_the_noise(paper: Model) -> None:
    model = paper.with_link("sensor_noise", std=1e-6).with_link("sensor_quantization")
    shown = simulate(model, np.zeros(1000), 1e-3, random=True) / 1e-6
    np.testing.assert_allclose(shown, np.rint(shown), atol=1e-9)
    assert np.ptp(shown) > 3.0
