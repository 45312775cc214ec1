"""How large a drift or a hum is, told from the recordings, not from what it took away."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.courses import sizes
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD, COUNT = 1e-3, 8000
TIME = PERIOD * np.arange(COUNT)
VOLTAGE = 70.0 - 70.0 * np.cos(2.0 * np.pi * 0.75 * TIME)


def test_a_drift_and_a_hum_are_as_large_as_they_were_planted() -> None:
    drift, hum = 4e-7 * TIME / TIME[-1], 5e-8 * np.sin(2.0 * np.pi * 50.0 * TIME)
    noise = 1e-8 * np.random.default_rng(3).standard_normal(COUNT)
    measured = simulate(nominal_model(), VOLTAGE, PERIOD) + drift + hum + noise
    evidence = Evidence.gather(
        [Recording("run", PERIOD, VOLTAGE, measured)], [], Conditions(), nominal_model()
    )
    model = nominal_model().with_link("thermal_drift").with_link("mains_hum", frequency=50.0)
    found = sizes(evidence, Trial(model, (), (0.0,), np.inf))
    used = evidence.used[0]
    assert found["thermal_drift"] == pytest.approx(np.std(drift[used]), rel=0.02)
    assert found["mains_hum"] == pytest.approx(np.std(hum), rel=0.02)


def test_what_has_no_course_of_its_own_is_not_among_them() -> None:
    evidence = Evidence.gather(
        [Recording("run", PERIOD, VOLTAGE, simulate(nominal_model(), VOLTAGE, PERIOD))],
        [],
        Conditions(),
        nominal_model(),
    )
    assert sizes(evidence, Trial(nominal_model().with_link("creep"), (), (0.0,), np.inf)) == {}
