"""Drift: a closed form live, and courses that follow any slow one."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import link_named
from microgripper_control.effects.sensor.thermal_drift import TENTHS
from microgripper_control.identification.nuisance import BLOCKS
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-2  # s
TIME = PERIOD * np.arange(3000)
NOISE = 15e-9  # m


def shapes(time: Array = TIME) -> Array:
    return link_named("thermal_drift").courses({}, time)


def test_live_it_is_one_thermal_mass(paper: Model) -> None:
    model = paper.with_link("thermal_drift", amplitude=2e-6, time_constant=7.0)
    x = simulate(model, np.zeros(3000), PERIOD, random=True)
    np.testing.assert_allclose(x, 2e-6 * (1.0 - np.exp(-TIME / 7.0)), rtol=1e-12, atol=1e-20)


def test_predictions_leave_it_out(paper: Model, lively: Array) -> None:
    model = paper.with_link("thermal_drift")
    np.testing.assert_array_equal(simulate(model, lively, PERIOD), simulate(paper, lively, PERIOD))


def test_weights_are_what_has_drifted_until_each_knot() -> None:
    np.testing.assert_allclose(shapes()[:, 0], 0.0, atol=1e-15)
    weights = np.array([1.0, -2.0, 0.5, 3.0, 1.0, 0.0, -1.0, 2.0, 2.5])
    time = np.linspace(0.0, 60.0, 61)
    found = weights @ shapes(time)
    np.testing.assert_allclose(found[6:-6:6], weights, atol=1e-12)
    assert found[-1] == pytest.approx(3.0)  # straight on


def test_between_two_knots_it_knows_of_the_next_ones_only() -> None:
    far = np.zeros(9)
    far[5] = 1.0  # the knot at 0.6
    course = far @ shapes()
    inside = course != 0.0
    assert TIME[inside][0] > 0.4 * TIME[-1] - PERIOD
    assert TIME[inside][-1] < 0.8 * TIME[-1] + PERIOD
    assert np.max(np.abs(course)) < 1.2


def test_the_knots_lie_where_the_blocks_of_a_held_out_recording_meet() -> None:
    assert TENTHS == BLOCKS


def test_a_steady_drift_is_met_exactly() -> None:
    weights = np.arange(1, 10) / 10.0
    np.testing.assert_allclose(weights @ shapes(), TIME / TIME[-1], atol=1e-12)


@pytest.mark.parametrize(
    ("course", "share"),
    [
        (1.0 - np.exp(-TIME / 5.0), 0.02),
        (1.0 - np.exp(-TIME / 30.0), 0.002),
        (np.sin(2.0 * np.pi * TIME / 50.0 + 0.4), 0.04),
        (np.sin(2.0 * np.pi * TIME / 20.0 + 0.4), 0.2),  # it turns in the last tenth
    ],
)
def test_slow_drifts_are_recovered_from_half_a_noisy_recording(course: Array, share: float) -> None:
    """Fitted to every other tenth, as held-out recordings are, and judged on the rest."""
    drift = 1e-6 * course
    noisy = drift + NOISE * np.random.default_rng(3).normal(size=len(drift))
    used = np.arange(3000) * 10 // 3000 % 2 == 0
    columns = np.vstack([shapes(), np.ones(3000)]).T
    weights = np.linalg.lstsq(columns[used], noisy[used], rcond=None)[0]
    error = (columns @ weights - drift)[~used]
    assert np.sqrt(np.mean(error**2)) < share * 1e-6 + 0.2 * NOISE


def test_no_faster_motion_passes_for_drift() -> None:
    """A motion of ten cycles a recording keeps all but a trace of itself."""
    wave = np.sin(2.0 * np.pi * TIME * 10.0 / TIME[-1])
    columns = shapes().T
    left = wave - columns @ np.linalg.lstsq(columns, wave, rcond=None)[0]
    assert np.std(left) > 0.98 * np.std(wave)
