"""Whether a force begins with what the way before the recordings has made of it."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial, moved, unfitted
from microgripper_control.diagnosis.search.beginning import begun_from_nothing
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

EFFECT = "restoring_force_hysteresis"
WAY = np.repeat([60.0, 110.0, 20.0, 80.0, 40.0, 60.0], 200)  # V, in steps
FREE = (("bouc_wen", "d"), (EFFECT, "alpha"))


def found(released: float, initial: Initial) -> Trial:
    """What becomes of a trial that has let nothing go, on a rig that may have; 1 nm of noise."""
    rig = nominal_model().with_link(
        EFFECT, alpha=2e6, distributed=1.0, widest=8e-6, released=released
    )
    shown = simulate(rig, WAY, 1e-3, initial=initial, initial_hysteresis=3e-7)
    noise = np.random.default_rng(7).normal(0.0, 1e-9, len(WAY))
    recordings = [Recording("planted", 1e-3, WAY, shown + noise)]
    evidence = Evidence.gather(recordings, (), Conditions(initial=initial), nominal_model())
    believed = rig.with_values({(EFFECT, "released"): 0.0})
    trial = unfitted(evidence, moved(evidence, Trial(believed, FREE, (0.0,), np.inf)))
    return begun_from_nothing(evidence, trial, EFFECT)


@pytest.mark.parametrize("released", [0.0, 1.0])
def test_the_recordings_decide(released: float) -> None:
    trial = found(released, Initial.FIRST_SAMPLE)
    assert trial.model.value(EFFECT, "released") == released
    assert trial.fitted_rmse == pytest.approx(1e-9, rel=0.1)


def test_from_rest_there_is_nothing_to_hold() -> None:
    assert found(1.0, Initial.REST).model.value(EFFECT, "released") == 0.0
