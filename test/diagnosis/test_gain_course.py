"""A gain that changes slowly is told from a drift."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.gain_course import Followed, followed
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD, COUNT = 2e-3, 8000
TIME = PERIOD * np.arange(COUNT)
VOLTAGE = 75.0 - 60.0 * np.cos(2.0 * np.pi * 0.9 * TIME)
SLOWLY = np.sin(1.3 * TIME / TIME[-1] + 0.4 * np.sin(5.0 * TIME / TIME[-1]))
NOISE = 1e-8  # m
ZERO = 3e-6  # m, of the sensor: what it shows is not where the rig is


def left(measured: Array) -> Followed:
    noise = NOISE * np.random.default_rng(3).standard_normal(COUNT)
    recording = Recording("run", PERIOD, VOLTAGE, measured + ZERO + noise)
    evidence = Evidence.gather([recording], [], Conditions(), nominal_model())
    free = tuple(("bouc_wen", name) for name in ("d", "alpha", "beta", "gamma"))
    model = nominal_model().with_values({("bouc_wen", "d"): 1.46e-7}).with_link("thermal_drift")
    return followed(evidence, Trial(model, free, (0.0,), np.inf))


def test_a_gain_that_changes_is_followed_by_a_course_of_its_own() -> None:
    found = left(simulate(nominal_model(), VOLTAGE, PERIOD) * (1.0 + 0.03 * SLOWLY))
    assert found.by_gain < 1.1 * NOISE
    assert found.by_drift > 2.0 * NOISE


def test_a_drift_is_followed_by_one_of_the_zero() -> None:
    found = left(simulate(nominal_model(), VOLTAGE, PERIOD) + 3e-7 * SLOWLY)
    assert found.by_drift < 1.1 * NOISE
    assert found.by_gain > 1.8 * NOISE


def test_noise_is_left_by_either() -> None:
    found = left(simulate(nominal_model(), VOLTAGE, PERIOD))
    assert found == pytest.approx((NOISE, NOISE), rel=0.02)
