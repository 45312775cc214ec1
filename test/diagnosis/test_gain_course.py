"""A gain that changes slowly is told from a drift."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.gain_course import gain_over_drift
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD, COUNT = 2e-3, 8000
TIME = PERIOD * np.arange(COUNT)
VOLTAGE = 75.0 - 60.0 * np.cos(2.0 * np.pi * 0.9 * TIME)
SLOWLY = np.sin(1.3 * TIME / TIME[-1] + 0.4 * np.sin(5.0 * TIME / TIME[-1]))
ZERO = 3e-6  # m, of the sensor: what it shows is not where the rig is


def ratio(measured: Array) -> float:
    noise = 1e-8 * np.random.default_rng(3).standard_normal(COUNT)
    recording = Recording("run", PERIOD, VOLTAGE, measured + ZERO + noise)
    evidence = Evidence.gather([recording], [], Conditions(), nominal_model())
    drift = Trial(nominal_model().with_link("thermal_drift"), (), (0.0,), np.inf)
    return gain_over_drift(evidence, drift)


def test_a_gain_that_changes_leaves_less_with_a_course_of_its_own() -> None:
    assert ratio(simulate(nominal_model(), VOLTAGE, PERIOD) * (1.0 + 0.03 * SLOWLY)) < 0.2


def test_a_drift_leaves_more_with_one_of_the_gain() -> None:
    assert ratio(simulate(nominal_model(), VOLTAGE, PERIOD) + 3e-7 * SLOWLY) > 2.0


def test_noise_leaves_as_much_with_either() -> None:
    assert ratio(simulate(nominal_model(), VOLTAGE, PERIOD)) == pytest.approx(1.0, abs=1e-3)
