"""k1 and k2 against planted values and limits."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.control.linearised import Linearised
from microgripper_control.paper.experiment import drive, hysteresis
from microgripper_control.paper.linearised import (
    fit_course,
    fit_equation_error,
    fit_linearised,
)
from microgripper_control.plant.model import Model

T = 1e-3


def test_planted_coefficients_come_back(plant: Model) -> None:
    truth = Linearised(2.3e-8, -0.533)
    voltage = drive(plant)
    h = truth.hysteresis(voltage, T)
    found = fit_linearised(voltage, h, T, Linearised(1e-8, -2.0))
    assert found.k1 == pytest.approx(truth.k1, rel=1e-5)
    assert found.k2 == pytest.approx(truth.k2, rel=1e-4)
    by_error = fit_equation_error(voltage, h, T)
    assert by_error.k1 == pytest.approx(truth.k1, rel=1e-3)
    assert by_error.k2 == pytest.approx(truth.k2, rel=2e-3)


def test_k1_does_not_depend_on_the_frequency_and_k2_is_in_proportion(plant: Model) -> None:
    slow, fast = (fit_course(plant, "sine", 2, f).found for f in (0.05, 20.0))
    assert fast.k1 == pytest.approx(slow.k1, rel=1e-4)
    assert fast.k2 / 20.0 == pytest.approx(slow.k2 / 0.05, rel=1e-4)


def test_without_beta_and_gamma_k1_is_alpha_d_and_k2_vanishes(plant: Model) -> None:
    straight = plant.with_values({("bouc_wen", "beta"): 0.0, ("bouc_wen", "gamma"): 0.0})
    found = fit_course(straight, "sine", 2, 1.0)
    v = plant.values("bouc_wen")
    assert found.found.k1 == pytest.approx(v["alpha"] * v["d"], rel=1e-4)
    assert abs(found.found.k2) < 1e-3
    assert found.rmse < 1e-4


def test_the_frequency_that_gives_the_printed_k2_does(plant: Model) -> None:
    asked = fit_course(plant, "triangle", 2, 1.0).frequency_of_printed_k2
    assert asked == pytest.approx(0.26, abs=0.005)
    found = fit_course(plant, "triangle", 2, asked).found
    assert found.k2 == pytest.approx(-0.533, rel=1e-3)


def test_no_better_coefficients_lie_nearby(plant: Model) -> None:
    voltage = drive(plant)
    h = hysteresis(plant, voltage)
    best = fit_course(plant, "sine", 5, 1.0).found

    def squares(k1: float, k2: float) -> float:
        error = Linearised(best.k1 * k1, best.k2 * k2).hysteresis(voltage, T) - h
        return float(np.sum(error**2))

    for k1, k2 in ((1.01, 1.0), (0.99, 1.0), (1.0, 1.01), (1.0, 0.99), (1.01, 1.01)):
        assert squares(k1, k2) > squares(1.0, 1.0)
