"""The nominal model counts as one measurement of its own parameters, and no more."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import refine
from microgripper_control.diagnosis.fits.prior import Prior
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD, NOISE = 1e-3, 15e-9
KEYS = tuple(("bouc_wen", name) for name in ("d", "alpha", "beta", "gamma"))


@pytest.fixture(scope="module")
def paper() -> Model:
    return load_model(Path(__file__).parents[2] / "config" / "apa120s.yaml")


def record(rig: Model, voltage: Array) -> Recording:
    noise = NOISE * np.random.default_rng(11).standard_normal(len(voltage))
    return Recording("given", PERIOD, voltage, simulate(rig, voltage, PERIOD) + noise)


def ramp(volts: float) -> Array:
    return np.linspace(0.0, volts, 4000)


def problem(paper: Model) -> Problem:
    recording = record(paper, ramp(5.0))
    return Problem(paper, [recording], Conditions(initial=Initial.REST), KEYS)


def at(paper: Model, **factors: float) -> Array:
    changed = {("bouc_wen", n): f * paper.value("bouc_wen", n) for n, f in factors.items()}
    return problem(paper).point(paper.with_values(changed), (0.0,))


def test_a_factor_of_e_is_one_standard_deviation(paper: Model) -> None:
    """White residuals are independent: the weight is their rms, to the error of tau."""
    white = np.random.default_rng(2).normal(0.0, 3e-8, 20000)
    prior = Prior(paper, problem(paper), white)
    np.testing.assert_array_equal(prior.rows(at(paper)), 0.0)
    rows = prior.rows(at(paper, d=np.e, gamma=-1.0, beta=0.25))
    np.testing.assert_allclose(rows, 3e-8 * np.array([1.0, 0.0, -0.75, -2.0]), rtol=0.06)


def test_correlated_residuals_count_as_few_samples(paper: Model) -> None:
    """Each value 25 times over: 25 samples are one, so a row weighs as 25 residuals."""
    values = np.random.default_rng(3).normal(0.0, 3e-8, 2000)
    point = at(paper, d=np.e)
    once = Prior(paper, problem(paper), values).rows(point)[0]
    often = Prior(paper, problem(paper), np.repeat(values, 25)).rows(point)[0]
    assert often / once == pytest.approx(5.0, rel=0.1)


def test_the_derivative_is_that_of_the_rows(paper: Model) -> None:
    prior = Prior(paper, problem(paper), np.random.default_rng(4).normal(0.0, 1e-8, 500))
    point = at(paper, d=1.3, alpha=0.4, beta=-0.5, gamma=2.0)
    step = 1e-6
    differences = [
        (prior.rows(point + step * unit) - prior.rows(point - step * unit)) / (2.0 * step)
        for unit in np.eye(len(point))
    ]
    np.testing.assert_allclose(prior.jacobian(point), np.transpose(differences), rtol=1e-6)


def test_what_a_recording_does_not_tell_stays_as_the_model_has_it(paper: Model) -> None:
    """A short ramp shows one slope: a fit that begins far off returns.

    It begins at rest: an unknown initial h, too, would trade with alpha.
    """
    at_rest = Conditions(initial=Initial.REST)
    evidence = Evidence.gather([record(paper, ramp(5.0))], [], at_rest, paper)
    start = nominal_trial(evidence, paper.with_values({("bouc_wen", "alpha"): 0.4}))
    found = refine(evidence, start)
    assert found.fitted_rmse == pytest.approx(NOISE, rel=0.05)
    assert found.model.value("bouc_wen", "alpha") == pytest.approx(0.0801, rel=0.2)


def test_what_it_tells_is_believed(paper: Model) -> None:
    """A parameter three times its nominal value, on loops that show it, comes out as it is."""
    rig = paper.with_values({("bouc_wen", "alpha"): 0.24})
    loops = 70.0 * (1.0 - np.cos(2.0 * np.pi * PERIOD * np.arange(6000)))
    recording = record(rig, loops * np.linspace(1.0, 0.3, 6000))
    evidence = Evidence.gather([recording], [], Conditions(), paper)
    found = refine(evidence, nominal_trial(evidence, paper))
    assert found.model.value("bouc_wen", "alpha") == pytest.approx(0.24, rel=0.01)
    assert found.fitted_rmse == pytest.approx(NOISE, rel=0.05)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_it_counts_too_where_mass_and_damping_show(paper: Model, seed: int) -> None:
    """Small steps of a soft rig that rings tell its mass, and d and alpha only together.

    Without the nominal model d went to 18 times what it is, with the same errors.
    """
    stiffness, frequency = 3.3e5, 2.0 * np.pi * 100.0
    soft = paper.with_values(
        {
            ("second_order", "m"): stiffness / frequency**2,
            ("second_order", "b"): 0.06 * stiffness / frequency,
            ("second_order", "k"): 3e5,
            ("second_order", "k_s"): 3e4,
        }
    )
    rig = soft.with_values({("second_order", "m"): 0.96 * soft.value("second_order", "m")})
    random = np.random.default_rng(seed)
    voltage = 50.0 + np.repeat(random.uniform(-5.0, 5.0, 30), 200)
    shown = simulate(rig, voltage, PERIOD, initial=Initial.FIRST_SAMPLE)
    reading = shown + 1e-7 * random.standard_normal(len(voltage))
    recording = Recording("given", PERIOD, voltage, reading)
    evidence = Evidence.gather([recording], [], Conditions(), soft)
    found = refit_trial(evidence, nominal_trial(evidence, soft))
    assert ("second_order", "m") in found.free
    assert found.model.value("second_order", "m") == pytest.approx(
        rig.value("second_order", "m"), rel=0.02
    )
    assert found.model.value("bouc_wen", "d") == pytest.approx(soft.value("bouc_wen", "d"), rel=0.1)
    assert found.rmse == pytest.approx(1e-7, rel=0.05)
