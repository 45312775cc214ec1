"""Which first guesses of an effect are fitted."""

from __future__ import annotations

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import base_of
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.diagnosis.search.screening import guesses
from microgripper_control.identification.nuisance import Conditions
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
