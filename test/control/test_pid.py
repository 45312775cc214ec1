"""The PID against its transfer function, its limits and its history."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from microgripper_control.control.pid import FADING, Pid, PidGains
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array

T = 1e-3
GAINS = PidGains(kp=1e6, ki=1e9, kd=2e3, derivative_filter=0.003, derivative_on_measurement=False)
ERRORS = 1e-6 * np.random.default_rng(0).standard_normal(300)


def run(pid: Pid, errors: Array, low: float = -math.inf, high: float = math.inf) -> Array:
    return np.array([pid.step(error, -error, low, high) for error in errors])


@pytest.mark.parametrize("lag", [0.0, 0.003])
def test_agrees_with_its_transfer_function(lag: float) -> None:
    gains = PidGains(1e6, 1e9, 2e3, lag, derivative_on_measurement=False)
    errors = np.concatenate([[0.0], ERRORS])  # the derivative needs a first sample
    expected = (
        gains.kp * errors
        + lfilter([gains.ki * T], [1.0, -1.0], errors)
        + lfilter([gains.kd, -gains.kd], [lag + T, -lag], errors)
    )
    np.testing.assert_allclose(run(Pid(gains, T), errors), expected, rtol=1e-9, atol=1e-12)


def test_a_jump_of_the_setpoint_does_not_kick_the_derivative_on_measurement() -> None:
    for on_measurement, kick in [(True, 0.0), (False, 2e3 * 1e-6 / (0.003 + T))]:
        pid = Pid(PidGains(0.0, 0.0, 2e3, 0.003, on_measurement), T)
        pid.step(0.0, 5e-6)
        assert pid.step(1e-6, 5e-6) == pytest.approx(kick)


def test_a_derivative_on_measurement_opposes_motion() -> None:
    pid = Pid(PidGains(kp=0.0, ki=0.0, kd=2e3, derivative_filter=0.0), T)
    pid.step(0.0, 5e-6)
    assert pid.step(0.0, 6e-6) == pytest.approx(-2e3 * 1e-6 / T)


@pytest.mark.parametrize("lag", [0.0, 0.003])
@pytest.mark.parametrize("how", ["not finite", "did not come"])
def test_over_lost_samples_the_derivative_is_what_it_was(how: str, lag: float) -> None:
    """The mean over the gap: of an even motion the same as before."""
    pid = Pid(PidGains(kp=0.0, ki=0.0, kd=2e3, derivative_filter=lag), T)
    answers = [pid.step(0.0, 1e-7 * tick) for tick in range(50)]
    if how == "did not come":
        pid.lose(20)
    else:
        assert {pid.step(0.0, math.nan) for _ in range(20)} == {answers[-1]}
    after = [pid.step(0.0, 1e-7 * tick) for tick in range(70, 100)]
    assert answers[-1] == pytest.approx(-0.2)
    assert after == pytest.approx(30 * [-0.2])


def test_a_bounded_output_does_not_wind_up() -> None:
    pid = Pid(PidGains(kp=1e6, ki=1e9, kd=0.0), T)
    outputs = run(pid, np.full(1000, 5e-6), 0.0, 10.0)
    assert outputs[-1] == 10.0
    assert pid.bounded
    # Unbounded, the integral would hold 5000 V; now the first contrary error takes it off the end.
    assert pid.step(-1e-6, 0.0, 0.0, 10.0) < 10.0 - 1.0
    assert not pid.bounded


def test_integration_goes_on_away_from_the_bound() -> None:
    pid = Pid(PidGains(kp=0.0, ki=1e9, kd=0.0), T)
    pid.integral = 50.0
    outputs = run(pid, np.full(45, -1e-6), 0.0, 10.0)
    assert outputs[38] == 10.0
    np.testing.assert_allclose(outputs[-5:], [9.0, 8.0, 7.0, 6.0, 5.0])


def test_a_change_of_gains_does_not_jump() -> None:
    for gains in [PidGains(9e6, 1e8, 8e3, 0.001, False), PidGains(0.0, 1e9, 0.0)]:
        pid, kept = Pid(GAINS, T), Pid(GAINS, T)
        run(pid, ERRORS)
        last = run(kept, ERRORS)[-1]
        pid.change_gains(gains)
        # The same sample again: without a change of error nothing but the integral moves.
        derivative = pid.step(ERRORS[-1], -ERRORS[-1]) - gains.ki * T * ERRORS[-1]
        decay = gains.derivative_filter / (gains.derivative_filter + T)
        step = kept._derivative * gains.kd / GAINS.kd * (1.0 - decay)  # the filter relaxes
        assert derivative == pytest.approx(last - step, rel=1e-12)


def test_joins_at_a_given_output() -> None:
    pid = Pid(GAINS, T)
    run(pid, ERRORS)
    assert pid.join(42.0, 3e-6, -3e-6) == pytest.approx(42.0, rel=1e-15)
    assert pid.step(3e-6, -3e-6) == pytest.approx(42.0 + GAINS.ki * T * 3e-6)


def test_joins_also_without_a_finite_sample() -> None:
    pid = Pid(GAINS, T)
    assert pid.join(42.0, math.nan, math.nan) == 42.0
    assert pid.step(0.0, 0.0) == 42.0


anything = st.floats(allow_nan=True, allow_infinity=True)


@given(st.lists(st.tuples(anything, anything), max_size=30), st.booleans())
def test_stays_bounded_and_recovers_whatever_it_is_given(
    samples: list[tuple[float, float]], on_measurement: bool
) -> None:
    gains = PidGains(1e6, 1e9, 2e3, 0.003, on_measurement)
    pid = Pid(gains, T, authority=160.0)
    for error, measurement in samples:
        assert 0.0 <= pid.step(error, measurement, 0.0, 160.0) <= 160.0
        assert abs(pid.integral) <= 160.0
    for error, end in [(-1e-6, 0.0), (1e-6, 160.0)]:  # 1 um is 1 V of integral a sample
        for _ in range(400):
            output = pid.step(error, -error, 0.0, 160.0)
        assert output == pytest.approx(end, abs=1.0)  # P stands against one sample's worth of I


def test_gains_out_of_range_are_named() -> None:
    with pytest.raises(MicrogripperError, match=r"ki = -1 is outside its range 0 \.\. 1e\+16 V"):
        PidGains(ki=-1.0)
    assert [p.unit for p in PidGains.parameters()] == ["V/m", "V/(m*s)", "V*s/m", "s"]


def test_another_signal_to_differentiate_does_not_jump() -> None:
    before = PidGains(kp=0.0, ki=0.0, kd=1e4, derivative_filter=0.01)
    pid = Pid(before, T)
    last = [pid.step(0.0, 1e-6 * k) for k in range(100)][-1]
    assert abs(last) > 5.0
    pid.change_gains(replace(before, derivative_on_measurement=False))
    assert pid.step(0.0, 100e-6) == pytest.approx(last, rel=1.1 * T / FADING)


def test_without_integral_action_a_take_over_is_forgotten() -> None:
    pid = Pid(PidGains(kp=1e5, ki=0.0), T)
    assert pid.join(50.0, 4e-6, 0.0) == pytest.approx(50.0)
    steps = [pid.step(4e-6, 0.0) for _ in range(round(10.0 * FADING / T))]
    assert steps[0] == pytest.approx(50.0, rel=1.1 * T / FADING)
    assert steps[-1] == pytest.approx(1e5 * 4e-6, rel=0.01)
