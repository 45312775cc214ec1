"""Which first guesses of an effect are fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import base_of
from microgripper_control.diagnosis.fits.trial import Trial, with_guess
from microgripper_control.diagnosis.search.labour import is_costly, is_costly_with
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.diagnosis.search.screening import guesses
from microgripper_control.effects.base import no_courses
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Conditions, Projection
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

EFFECT = "rate_dependent_hysteresis"


def test_a_law_with_parts_is_started_from_more_than_one_of_them() -> None:
    """The best of the guesses are of one kind; the best of another has its chance."""
    paper = nominal_model()
    t = 1e-3 * np.arange(6000)
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * (1.0 + 2.0 * t) * t)
    rig = paper.with_link(EFFECT, strength=0.0, late=0.5, memory=4e-3)
    noise = np.random.default_rng(1).normal(0.0, 15e-9, len(t))
    recording = Recording("run", 1e-3, voltage, simulate(rig, voltage, 1e-3) + noise)
    evidence = Evidence.gather([recording], (), Conditions(), paper)
    nominal = nominal_trial(evidence, paper)
    bases = [base_of(evidence, trial) for trial in (refit_trial(evidence, nominal), nominal)]
    found = guesses(evidence, bases, EFFECT, 2)
    late = [guess.model.value(EFFECT, "late") != 0.0 for guess in found]
    assert late[0], "what was planted comes first"
    assert not all(late)
    assert len(found) <= 5
    assert [guess.left for guess in found] == sorted(guess.left for guess in found)


def test_what_an_effect_was_alone_is_a_guess_for_beside_others() -> None:
    """A mode so little damped that it lies between any two first guesses."""
    paper = nominal_model()
    voltage = 60.0 + 50.0 * np.sign(np.sin(2.0 * np.pi * 0.9 * 1e-3 * np.arange(6000)))
    mode = {"share": 0.02, "frequency": 41.6, "damping": 0.01}
    rig = paper.with_link("extra_resonance", **mode)
    mode = rig.values("extra_resonance")
    noise = np.random.default_rng(2).normal(0.0, 5e-9, len(voltage))
    recording = Recording("run", 1e-3, voltage, simulate(rig, voltage, 1e-3) + noise)
    evidence = Evidence.gather([recording], (), Conditions(), paper)
    bases = [base_of(evidence, refit_trial(evidence, nominal_trial(evidence, paper)))]
    before, after = (
        guesses(evidence, bases, "extra_resonance", 1, alone) for alone in ((), [mode])
    )
    assert mode not in [guess.model.values("extra_resonance") for guess in before]
    assert mode in [guess.model.values("extra_resonance") for guess in after]
    assert after[0].left < 0.2 * before[0].left


@pytest.mark.parametrize("period", [1e-6, 1e-3, 50.0])
def test_at_any_rate_there_is_a_first_guess_within_the_ranges(period: float) -> None:
    """A creep over three samples may be faster than its range, a limit of the slope slower."""
    paper = nominal_model()
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * np.arange(1000) / 250.0)
    recording = Recording("run", period, voltage, simulate(paper, voltage, period))
    evidence = Evidence.gather([recording], (), Conditions(), paper)
    refit = Trial(paper, (), (0.0,), 1e-9)
    for name, link in registry().items():
        for values in link.starts(evidence.scales):
            begun = with_guess(paper, name, values)
            inside = {key: link.parameter(key).nearest(value) for key, value in values.items()}
            assert inside.items() <= begun.values(name).items()
        if starts := link.starts(evidence.scales):
            first = with_guess(paper, name, starts[0])
            assert is_costly_with(evidence, refit, name) == is_costly(evidence, first)


def test_a_lag_promises_nothing_where_it_should_be_negative() -> None:
    """A rig that answers earlier than its model."""
    paper = nominal_model()
    late = paper.with_link("amplifier_lag", lag=5e-3)
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * 4e-3 * np.arange(3000))
    noise = np.random.default_rng(5).normal(0.0, 5e-9, len(voltage))
    recording = Recording("run", 1e-3, voltage, simulate(paper, voltage, 1e-3) + noise)
    evidence = Evidence.gather([recording], (), Conditions(), late)
    nominal = nominal_trial(evidence, late)
    kept = tuple(key for key in nominal.free if key[0] != "amplifier_lag")
    base = base_of(evidence, replace(nominal, free=kept))
    rest = Projection(base.basis)(base.residual)
    found = guesses(evidence, [base], "sensor_lag", 1)
    assert found
    assert all(guess.least == pytest.approx(rest @ rest) for guess in found)
    assert all(guess.left > guess.least for guess in found)


@pytest.mark.parametrize(("amplitude", "found"), [(0.0, []), (7e-9, [50.0])])
def test_a_hum_that_takes_nothing_away_is_no_start(amplitude: float, found: list[float]) -> None:
    """Beside much creep: its courses are as strong as fits best already."""
    paper = nominal_model()
    t = 1e-3 * np.arange(20_000)
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * 0.4 * t)
    rig = paper.with_link("creep", strength=0.05)
    hum = amplitude * np.sin(2.0 * np.pi * 50.0 * t + 1.0)
    noise = np.random.default_rng(5).normal(0.0, 10e-9, len(t))
    recording = Recording("run", 1e-3, voltage, simulate(rig, voltage, 1e-3) + hum + noise)
    evidence = Evidence.gather([recording], (), Conditions(), paper)
    base = base_of(evidence, refit_trial(evidence, nominal_trial(evidence, paper)))
    starts = guesses(evidence, [base], "mains_hum", 4)
    assert [guess.model.value("mains_hum", "frequency") for guess in starts] == found


def test_beside_what_has_courses_a_guess_is_made_stronger_as_well() -> None:
    """Creep is projected off, and says nothing of how strong a stiffening should be."""
    paper = nominal_model()
    assert registry()["creep"].courses is not no_courses
    rig = paper.with_link("creep").with_link("nonlinear_stiffness", quadratic=2e11)
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * 4e-3 * np.arange(3000))
    recording = Recording("run", 1e-3, voltage, simulate(rig, voltage, 1e-3))
    evidence = Evidence.gather([recording], (), Conditions(), paper)
    nominal = nominal_trial(evidence, paper)
    base = base_of(evidence, replace(nominal, model=paper.with_link("creep")))
    name = "nonlinear_stiffness"
    as_declared = [
        with_guess(base.trial.model, name, values).values(name)
        for values in registry()[name].starts(evidence.scales)
    ]
    found = guesses(evidence, [base], name, 1)
    assert found[0].model.values(name) not in as_declared
    assert found[0].left < 0.05 * float(base.residual @ base.residual)
