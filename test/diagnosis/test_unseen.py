"""A gap that shows only where it is judged is told from one that shows where it is fitted."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.diagnose import candidate_names, diagnose
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.fits.unseen import unseen_gap, unseen_warning
from microgripper_control.diagnosis.search.refit import nominal_trial, refits
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD, NOISE = 1e-3, 8e-9
SLOW, FAST = 1.0, 15.0  # Hz
LIMITED = nominal_model().with_link("slew_limit", time=1.0 / 2500.0)


def triangle(rates: Array) -> Array:
    """0 to 140 V, at so many cycles a second in each sample, Hz."""
    return 140.0 * np.abs(2.0 * (np.cumsum(rates) * PERIOD % 1.0) - 1.0)


def recorded(rig: Model, name: str, rates: Array, seed: int) -> Recording:
    voltage = triangle(rates)
    noise = NOISE * np.random.default_rng(seed).normal(size=len(voltage))
    answer = simulate(rig, voltage, PERIOD, initial=Initial.FIRST_SAMPLE) + noise
    return Recording(name, PERIOD, voltage, answer)


def gathered(rig: Model, when: str) -> Evidence:
    """Triangles whose fast ones are in the last block, in the ninth, or in another recording."""
    rates = np.full(8000, SLOW)
    begin = {"judged block": 7250, "fitted block": 6450, "apart": 8000}[when]
    rates[begin : begin + 700] = FAST
    others = [recorded(rig, "fast", np.full(2000, FAST), 2)] if when == "apart" else []
    return Evidence.gather([recorded(rig, "slow", rates, 1)], others, Conditions(), nominal_model())


def refit(evidence: Evidence) -> Trial:
    return refits(evidence, nominal_trial(evidence, evidence.nominal))[0]


@pytest.mark.parametrize(
    ("when", "told"),
    [
        ("judged block", "only the held-out blocks show the gap"),
        ("apart", "only the held-out recordings show the gap"),
    ],
)
def test_a_rate_that_only_what_judges_reaches(when: str, told: str) -> None:
    evidence = gathered(LIMITED, when)
    trial = refit(evidence)
    assert unseen_gap(evidence, trial)
    warning = unseen_warning(evidence, trial)
    assert warning.startswith(told)
    assert "before any of it was fitted" in warning  # the errors of the result are others
    joined = evidence.joined()
    there = refit(joined)
    assert not unseen_gap(joined, there)
    assert there.fitted_rmse > 10.0 * NOISE


@pytest.mark.parametrize("limited", [True, False])
def test_a_gap_that_shows_where_it_is_fitted_or_none(limited: bool) -> None:
    rig, when = (LIMITED, "fitted block") if limited else (nominal_model(), "judged block")
    evidence = gathered(rig, when)
    assert not unseen_gap(evidence, refit(evidence))


@pytest.mark.parametrize("hardening", [0.0, 2e16])
def test_what_shows_in_one_held_out_block_is_named(hardening: float) -> None:
    """Alone, and beside an effect that shows everywhere and is the larger one there."""
    rig = LIMITED.with_link("nonlinear_stiffness", cubic=hardening) if hardening else LIMITED
    whole = gathered(rig, "judged block")
    expected = {"slew_limit", "nonlinear_stiffness"} if hardening else {"slew_limit"}
    others = [name for name in candidate_names() if name not in (*expected, "amplifier_lag")]
    found = diagnose(nominal_model(), whole.fitted, without=others, jobs=1)
    assert set(found.effects) == expected
    assert any("held-out blocks" in line for line in found.warnings)
    assert found.gap.augmented < 1.3 * NOISE
