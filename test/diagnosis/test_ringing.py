"""Which natural frequencies a rig may have that rings between its samples."""

from __future__ import annotations

import math

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial, refits
from microgripper_control.diagnosis.search.ringing import other_frequencies, pace
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3  # s
STIFFNESS = 3.3e5  # N/m
NOISE = 15e-9  # m


def soft_rig(frequency: float) -> Model:
    """A stack on a soft mount that rings at a frequency, Hz, with a damping ratio of 0.03."""
    omega = 2.0 * math.pi * frequency
    mechanics = {"m": STIFFNESS / omega**2, "b": 0.06 * STIFFNESS / omega, "k_s": 0.3e5}
    values = {("second_order", name): value for name, value in (mechanics | {"k": 3e5}).items()}
    return nominal_model().with_values(values)


def steps(rig: Model, model: Model, sigma: float = NOISE) -> Evidence:
    """A staircase of random steps, recorded with the rig and explained with the model."""
    rng = np.random.default_rng(5)
    voltage = np.repeat(rng.uniform(0.0, 100.0, 40), 200)
    said = simulate(rig, voltage, PERIOD) + sigma * rng.normal(size=len(voltage))
    recording = Recording("steps", PERIOD, voltage, said)
    return Evidence.gather([recording], (), Conditions(), model)


def hertz(trial: Trial) -> float:
    return pace(trial.model) / (2.0 * math.pi)


@pytest.mark.parametrize("frequency", [1180.0, 1424.0, 1560.0])
def test_a_rig_that_rings_above_half_the_sampling_rate_is_found(frequency: float) -> None:
    """Also where a fit from the model's 1300 Hz would end at another frequency."""
    model = soft_rig(1300.0)
    evidence = steps(soft_rig(frequency), model)
    best = refits(evidence, nominal_trial(evidence, model))[0]
    assert hertz(best) == pytest.approx(frequency, rel=1e-3)
    assert best.fitted_rmse < 1.1 * NOISE


def test_a_rig_that_rings_behind_a_delay_is_found() -> None:
    """Parts of a sample show in the ringing, so a fit from 1300 Hz and 2.7 ms ends there."""
    model = soft_rig(1300.0).with_link("transport_delay", delay=2.7e-3)
    evidence = steps(soft_rig(1180.0).with_link("transport_delay", delay=2.35e-3), model)
    best = refits(evidence, nominal_trial(evidence, model))[0]
    assert best.fitted_rmse < 1.1 * NOISE
    assert best.model.value("transport_delay", "delay") == pytest.approx(2.35e-3, rel=1e-3)


def test_the_image_that_the_sampling_makes_of_it_is_kept() -> None:
    """1424 Hz rings at 1000 samples/s much like 1576 Hz: beside noise they are rivals."""
    model = soft_rig(1300.0)
    evidence = steps(soft_rig(1424.0), model, sigma=2e-6)
    found = [hertz(trial) for trial in refits(evidence, nominal_trial(evidence, model))]
    assert min(abs(f / 1424.0 - 1.0) for f in found) < 0.01
    assert min(abs(f / 1576.0 - 1.0) for f in found) < 0.02


def test_a_stiff_rig_has_one_frequency() -> None:
    paper = nominal_model()
    evidence = steps(paper, paper)
    assert other_frequencies(evidence, refit_trial(evidence, nominal_trial(evidence, paper))) == []
