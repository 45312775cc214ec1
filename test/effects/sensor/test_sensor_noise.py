"""Noise: white, Gaussian, and the same again from the same seed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

STD = 15e-9  # m
COUNT = 200_000


def noise(paper: Model, seed: float, count: int = COUNT) -> Array:
    model = paper.with_link("sensor_noise", std=STD, seed=seed)
    return simulate(model, np.zeros(count), 1e-3, random=True)


def test_it_is_gaussian(paper: Model) -> None:
    drawn = noise(paper, 1.0) / STD
    assert stats.kstest(drawn, "norm").pvalue > 0.01
    assert np.mean(drawn) == pytest.approx(0.0, abs=4.0 / np.sqrt(COUNT))
    assert np.std(drawn) == pytest.approx(1.0, abs=4.0 / np.sqrt(2 * COUNT))


def test_it_is_white(paper: Model) -> None:
    drawn = noise(paper, 2.0) / STD
    for lag in (1, 2, 3, 10, 1000):
        correlation = np.mean(drawn[lag:] * drawn[:-lag])
        assert correlation == pytest.approx(0.0, abs=4.0 / np.sqrt(COUNT))


def test_a_seed_repeats_and_another_differs(paper: Model) -> None:
    np.testing.assert_array_equal(noise(paper, 3.0, 1000), noise(paper, 3.0, 2000)[:1000])
    correlation = np.corrcoef(noise(paper, 3.0), noise(paper, 4.0))[0, 1]
    assert correlation == pytest.approx(0.0, abs=4.0 / np.sqrt(COUNT))


def test_predictions_leave_it_out(paper: Model, lively: Array) -> None:
    np.testing.assert_array_equal(
        simulate(paper.with_link("sensor_noise"), lively, 1e-3), simulate(paper, lively, 1e-3)
    )
