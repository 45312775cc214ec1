"""Where the voltage is held and the rig rests within a sample, a delay shows by whole samples."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import refine
from microgripper_control.diagnosis.fits.trial import Trial, fitted_keys
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD = 1e-3
TIME = PERIOD * np.arange(6000)
VOLTAGE = 70.0 * (1.0 - np.cos(2.0 * np.pi * 1.3 * TIME))
KEY = ("transport_delay", "delay")
REST = Conditions(initial=Initial.REST)


def late(samples: float) -> Model:
    return nominal_model().with_link("transport_delay", delay=samples * PERIOD)


def recorded(samples: float) -> Recording:
    clean = simulate(late(samples), VOLTAGE, PERIOD, initial=Initial.FIRST_SAMPLE)
    return Recording("run", PERIOD, VOLTAGE.copy(), clean)


@pytest.mark.parametrize("guess", [0.3, 3.5, 4.99])
def test_its_slope_is_that_over_the_sample_around_it(guess: float) -> None:
    problem = Problem(late(guess), [recorded(9.5)], REST, (KEY,))
    slope = problem.jacobian(np.ones(1))[:, 0]
    back, ahead = max(0.0, guess - 0.5), max(1.0, guess + 0.5)
    unit = guess * PERIOD
    over = [problem.residuals(np.array([end * PERIOD / unit])) for end in (back, ahead)]
    assert np.allclose(slope, (over[1] - over[0]) * guess, rtol=1e-6, atol=1e-12)
    assert np.max(np.abs(slope)) > 0.0


@pytest.mark.parametrize("guess", [3.5, 22.5])
def test_a_fit_walks_over_as_many_samples_as_it_must(guess: float) -> None:
    """The first guesses are several samples apart where a delay is long."""
    evidence = Evidence.gather([recorded(11.5)], [], Conditions(), nominal_model())
    model = late(guess)
    free = fitted_keys(model, ["bouc_wen", "transport_delay"])
    found = refine(evidence, Trial(model, free, (0.0,), np.inf))
    assert 11.0 <= found.model.value(*KEY) / PERIOD <= 12.0


def test_where_the_voltage_runs_smoothly_its_slope_is_exact() -> None:
    problem = Problem(late(3.5), [recorded(3.5)], Conditions(Hold.FIRST, Initial.REST), (KEY,))
    slope = problem.jacobian(np.ones(1))[:, 0]
    step = 1e-4
    apart = [problem.residuals(np.array([1.0 + side * step])) for side in (-1.0, 1.0)]
    assert np.allclose(slope, (apart[1] - apart[0]) / (2.0 * step), rtol=1e-3, atol=1e-9)
