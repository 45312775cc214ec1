"""A rig without hysteresis is said to have none, instead of getting a shape that cancels it."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.identification.ends import hold_at_ends
from microgripper_control.identification.fit import fit
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.start import ALPHA, BETA, GAMMA, D
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3
VOLTAGE = 75.0 - 75.0 * np.cos(2.0 * np.pi * 0.5 * PERIOD * np.arange(4000))


def recorded(alpha: float, seed: int) -> Recording:
    rig = nominal_model().with_values({ALPHA: alpha})
    noise = 15e-9 * np.random.default_rng(seed).standard_normal(len(VOLTAGE))
    return Recording("run", PERIOD, VOLTAGE, simulate(rig, VOLTAGE, PERIOD) + noise)


@pytest.mark.parametrize("seed", range(3))
def test_a_straight_rig_has_no_hysteresis_to_shape(seed: int) -> None:
    found = fit(nominal_model(), [recorded(0.0, seed)])
    assert found.determined == (D,)
    assert found.model.value(*D) == pytest.approx(1.4447e-7, rel=1e-3)
    reasons = {entry.key: entry.reason for entry in found.undetermined}
    assert {ALPHA, BETA, GAMMA} <= reasons.keys()
    assert "no hysteresis" in reasons[ALPHA]
    alpha = found.model.settings["bouc_wen"]["alpha"]
    assert alpha.value == 0.0
    assert alpha.ends[1] < 0.005
    assert found.rmse[0] == pytest.approx(15e-9, rel=0.05)


def test_a_little_hysteresis_is_some() -> None:
    found = fit(nominal_model(), [recorded(0.02, 3)])
    assert ALPHA in found.determined
    assert found.model.value(*ALPHA) == pytest.approx(0.02, rel=0.3)


def test_what_ends_on_a_bound_is_named_and_does_not_widen_the_others() -> None:
    model = nominal_model().with_values({ALPHA: 6e-19})
    problem = Problem(model, [recorded(0.0, 4)], Conditions(), (D, ALPHA, BETA, GAMMA))
    z = problem.point(model, [0.0])
    _, smaller, named = hold_at_ends(problem, z)
    reasons = {entry.key: entry.reason for entry in named}
    assert smaller.free == (D,)
    assert reasons[ALPHA] == "it ends on its lower bound, 0"
    assert reasons[BETA] == reasons[GAMMA] == "the recording leaves it open altogether"
