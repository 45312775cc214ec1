"""Ziegler and Nichols' rules and margins on plants whose answers are known."""

from __future__ import annotations

import control
import numpy as np
import pytest

from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised
from microgripper_control.control.pid import Pid, PidGains
from microgripper_control.control.tuning import loop_margins
from microgripper_control.paper.linear_plant import state_space
from microgripper_control.paper.tuning_rules import (
    continuous_margins,
    controller_in_z,
    ideal_gains,
    reaction_curve_gains,
    sampled_loop,
    sampled_margins,
    ultimate_gains,
)

T = 1e-3
NO_HYSTERESIS = Linearised(0.0, -1e-6)


def gains(identified: Identified, p: float, i: float, d: float) -> PidGains:
    """Gains relative to the plant's."""
    k = identified.gain
    return ideal_gains(p / k, i / (k * T), d * T / k)


def test_a_piezo_at_1_khz_is_two_samples_of_dead_time(identified: Identified) -> None:
    """K z^-2 oscillates with a gain of 1/K and a period of four samples."""
    found = ultimate_gains(sampled_loop(identified, NO_HYSTERESIS, T))
    assert found.kp * identified.gain == pytest.approx(0.6, rel=1e-4)
    assert found.kp / found.ki == pytest.approx(4.0 * T / 2.0, rel=1e-4)
    assert found.kd / found.kp == pytest.approx(4.0 * T / 8.0, rel=1e-4)
    pi = ultimate_gains(sampled_loop(identified, NO_HYSTERESIS, T), derivative=False)
    assert pi.kp * identified.gain == pytest.approx(0.45, rel=1e-4)
    assert pi.kp / pi.ki == pytest.approx(4.0 * T / 1.2, rel=1e-4)
    assert pi.kd == 0.0


def test_the_reaction_curve_of_a_lag_with_dead_time() -> None:
    lag, dead, gain = 0.5, 0.1, 2.0
    time = np.linspace(0.0, 5.0, 50_001)
    response = gain * -np.expm1(-np.maximum(time - dead, 0.0) / lag)
    found = reaction_curve_gains(time, response)
    assert found.kp == pytest.approx(1.2 * lag / (gain * dead), rel=1e-3)
    assert found.kp / found.ki == pytest.approx(2.0 * dead, rel=1e-3)
    assert found.kd / found.kp == pytest.approx(dead / 2.0, rel=1e-3)


@pytest.mark.parametrize(
    ("p", "i", "d"), [(0.0, 1.0 / 3.0, 0.0), (0.45, 0.135, 0.0), (0.05, 0.5, 0.3)]
)
def test_margins_agree_with_the_controllers_own(
    identified: Identified, p: float, i: float, d: float
) -> None:
    chosen = gains(identified, p, i, d)
    found = sampled_margins(sampled_loop(identified, NO_HYSTERESIS, T), chosen)
    own = loop_margins(identified, chosen, T)
    assert found.gain == pytest.approx(own.gain, rel=1e-3)
    assert found.phase == pytest.approx(own.phase, rel=1e-3)
    assert found.crossover == pytest.approx(own.crossover, rel=1e-3)


def test_the_loop_is_stable_up_to_its_gain_margin(identified: Identified) -> None:
    loop = sampled_loop(identified, Linearised(2.3e-8, -1.6), T)
    chosen = gains(identified, 0.1, 0.4, 0.2)
    margin = sampled_margins(loop, chosen).gain
    for factor, stable in ((0.999, True), (1.001, False)):
        scaled = margin * factor * loop
        assert (sampled_margins(scaled, chosen).gain > 0.0) is stable


def test_z_n_for_pid_is_unstable_on_dead_time_and_for_pi_is_not(identified: Identified) -> None:
    loop = sampled_loop(identified, NO_HYSTERESIS, T)
    assert sampled_margins(loop, ultimate_gains(loop)).gain == 0.0
    assert sampled_margins(loop, ultimate_gains(loop, derivative=False)).gain > 1.5


def test_the_pid_in_z_is_the_pid_that_runs() -> None:
    chosen = PidGains(2.0, 30.0, 0.01, derivative_filter=0.004, derivative_on_measurement=False)
    errors = np.random.default_rng(3).normal(size=50)
    pid = Pid(chosen, T)
    pid.step(0.0, 0.0)  # the derivative of the first error counts from zero
    run = [pid.step(float(error), 0.0) for error in errors]
    _, answer = control.forced_response(
        controller_in_z(chosen, T), T * np.arange(len(errors)), errors
    )
    assert run == pytest.approx(answer, rel=1e-9)


def test_continuous_margins_of_an_integrating_loop(identified: Identified) -> None:
    """Pure integral action crosses |L| = 1 at ki K, far below the resonance: 90 degrees left."""
    plant = state_space(identified, NO_HYSTERESIS, flexure=True)
    ki = 100.0 / identified.gain
    found = continuous_margins(plant, ideal_gains(0.0, ki, 0.0))
    assert found.phase == pytest.approx(90.0, abs=0.1)
    # L is real at the natural frequency, where the plant turns by 90 degrees: ki K m / b.
    assert found.gain == pytest.approx(identified.b / (100.0 * identified.m), rel=1e-3)
