"""The amplifier's lag against linear theory, and an integrator with hysteresis behind it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete, lfilter
from scipy.signal import step as step_response

from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

LAG = 2e-3  # s
STEPS = (0.1e-3, 0.35e-3, 0.05e-3, 0.5e-3)  # s
Alone = Callable[..., Array]

every_order = pytest.mark.parametrize("c", [0.0, 1e-9, 0.1, 0.25, 0.2500001, 0.4, 0.5, 1.0])


def theory(c: float, t: Array) -> Array:
    """Step response in closed form, t in units of the lag."""
    if c == 0.0:
        return 1.0 - np.exp(-t)
    root = np.sqrt(complex(1.0 - 4.0 * c))
    slow, fast = (1.0 + root) / 2.0, (1.0 - root) / 2.0  # lags in a row, of sum 1 and product c
    if abs(root) < 1e-9:
        return 1.0 - (1.0 + 2.0 * t) * np.exp(-2.0 * t)
    return np.real(1.0 - (slow * np.exp(-t / slow) - fast * np.exp(-t / fast)) / root)


@every_order
def test_a_held_step_is_followed_exactly(alone: Alone, c: float) -> None:
    values = {"lag": LAG, "curvature": c}
    out = alone("amplifier_lag", values, np.full(40, 7.0), STEPS)
    t = np.cumsum(np.resize(STEPS, 40)) / LAG
    np.testing.assert_allclose(out, 7.0 * theory(c, t), rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("c", [0.1, 0.25, 0.5, 1.0])
@pytest.mark.parametrize(("ramped", "method"), [(False, "zoh"), (True, "foh")])
def test_any_input_is_followed_exactly(alone: Alone, c: float, ramped: bool, method: str) -> None:
    """Against scipy's discretisation of the transfer function."""
    u = np.random.default_rng(0).normal(size=200)
    u[0] = 0.0  # so that it makes no difference which way the first sample is reached
    step = 0.3e-3
    system = ([1.0], [c * LAG**2, LAG, 1.0])
    numerator, denominator, _ = cont2discrete(system, step, method)
    expected = lfilter(numerator[0], denominator, u)
    out = alone("amplifier_lag", {"lag": LAG, "curvature": c}, u, (step,), ramped=ramped)
    # Ours is the output at the end of a step, scipy's is the one at the sample.
    if ramped:
        np.testing.assert_allclose(out, expected, rtol=0.0, atol=1e-9)
    else:
        np.testing.assert_allclose(out[:-1], expected[1:], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("c", "third", "d"), [(0.25, 1 / 3, 0.0), (0.5, 0.2, 0.0), (0.25, 0.5, 0.25), (0.4, 0.3, 0.9)]
)
def test_a_further_lag_stands_behind_the_others(
    alone: Alone, c: float, third: float, d: float
) -> None:
    """Against scipy's step response of the product of both transfer functions."""
    rest, last = (1.0 - third) * LAG, third * LAG
    system = ([1.0], np.polymul([c * rest**2, rest, 1.0], [d * last**2, last, 1.0]))
    t = 2e-5 * np.arange(1001)
    expected = step_response(system, T=t)[1][1:]
    values = {"lag": LAG, "curvature": c, "third": third, "third_curvature": d}
    np.testing.assert_allclose(
        alone("amplifier_lag", values, np.ones(1000), (2e-5,)), expected, atol=3e-5
    )
    ramp = alone("amplifier_lag", values, 500.0 * t[1:], (2e-5,), ramped=True)
    np.testing.assert_allclose(ramp[-10:], 500.0 * (t[-10:] - LAG), atol=2e-3)


@every_order
def test_it_is_late_by_the_lag_behind_a_ramp(alone: Alone, c: float) -> None:
    t = 1e-3 * np.arange(1, 200)
    values = {"lag": LAG, "curvature": c}
    out = alone("amplifier_lag", values, 500.0 * t, (1e-3,), ramped=True)
    np.testing.assert_allclose(out[50:], 500.0 * (t[50:] - LAG), atol=1e-6)


@every_order
def test_nothing_resonates_more_than_theory(alone: Alone, c: float) -> None:
    peak = 1.0 if c <= 0.5 else c / np.sqrt(c - 0.25)
    t = 1e-4 * np.arange(4000)
    for frequency in (20.0, 50.0, 80.0, 110.0, 200.0):
        u = np.sin(2.0 * np.pi * frequency * t)
        out = alone("amplifier_lag", {"lag": LAG, "curvature": c}, u, (1e-4,), ramped=True)
        assert np.max(np.abs(out[2000:])) < peak


def test_a_step_is_overshot_only_above_two_equal_lags(alone: Alone) -> None:
    steps = (1e-5,) * 100
    for c, over in ((0.25, 0.0), (0.5, np.exp(-np.pi)), (1.0, np.exp(-np.pi / np.sqrt(3.0)))):
        out = alone("amplifier_lag", {"lag": LAG, "curvature": c}, np.ones(2500), steps)
        assert np.max(out) == pytest.approx(1.0 + over, abs=1e-5)


def test_a_lag_too_short_to_be_squared_is_none(alone: Alone) -> None:
    values = {"lag": 1e-200, "curvature": 0.5, "third": 0.0}
    x = np.random.default_rng(11).normal(size=50)
    np.testing.assert_array_equal(alone("amplifier_lag", values, x, (1e-3,)), x)


@pytest.mark.parametrize("c", [0.0, 0.25, 0.5, 1.0])
@pytest.mark.parametrize("lag", [2e-5, 3e-4, 2e-3])
def test_a_linear_rig_behind_it_meets_theory(
    slow: Model,
    without_hysteresis: Callable[[Model], Model],
    lively: Array,
    filtered: Callable[..., Array],
    lag: float,
    c: float,
) -> None:
    linear = without_hysteresis(slow)
    absent = simulate(linear, lively, 1e-3)
    expected = filtered(linear, lively, ([1.0], [c * lag**2, lag, 1.0]))
    found = simulate(linear.with_link("amplifier_lag", lag=lag, curvature=c), lively, 1e-3)
    share = 0.05 if c == 1.0 else 0.03
    assert np.linalg.norm(found - expected) < share * np.linalg.norm(absent - expected)


@pytest.mark.parametrize("lag", [3e-4, 2e-3])
def test_a_linear_rig_behind_four_lags_meets_theory(
    slow: Model,
    without_hysteresis: Callable[[Model], Model],
    lively: Array,
    filtered: Callable[..., Array],
    lag: float,
) -> None:
    linear = without_hysteresis(slow)
    half = [0.4 * (0.5 * lag) ** 2, 0.5 * lag, 1.0]
    expected = filtered(linear, lively, ([1.0], np.polymul(half, half)))
    values = {"lag": lag, "curvature": 0.4, "third": 0.5, "third_curvature": 0.4}
    found = simulate(linear.with_link("amplifier_lag", **values), lively, 1e-3)
    absent = simulate(linear, lively, 1e-3)
    assert np.linalg.norm(found - expected) < 0.05 * np.linalg.norm(absent - expected)


def test_with_hysteresis_behind_it_meets_an_integrator(paper: Model) -> None:
    lag, c, period = 4e-4, 0.2, 1e-3
    u = np.array([60.0, 60.0, 140.0, 90.0, 90.0, 20.0, 20.0, 110.0, 0.0, 0.0])
    w, s = paper.values("bouc_wen"), paper.values("second_order")

    def slope(t: float, y: Array, command: float) -> list[float]:
        voltage, rate, h, x, v = y
        grow = w["alpha"] * w["d"] * rate - w["beta"] * abs(rate) * h - w["gamma"] * rate * abs(h)
        force = s["k"] * (w["d"] * voltage - h) - s["b"] * v - (s["k"] + s["k_s"]) * x
        bend = (command - voltage - lag * rate) / (c * lag**2)
        return [rate, bend, grow, v, force / s["m"]]

    y, expected = np.zeros(5), [0.0]
    for command in u[:-1]:
        solved = solve_ivp(
            slope, (0.0, period), y, "DOP853", args=(command,), rtol=1e-9, atol=1e-14
        )
        y = solved.y[:, -1]
        expected.append(y[3])
    found = simulate(paper.with_link("amplifier_lag", lag=lag, curvature=c), u, period)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=2e-4 * 20e-6)


def test_a_planted_lag_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    for truth in ([6e-4, 0.02], [1.5e-3, 0.3]):
        rig = paper.with_link("amplifier_lag", lag=truth[0], curvature=truth[1])
        start = {"lag": 1e-3, "curvature": 0.15}
        found, errors = recover(rig, "amplifier_lag", start, lively, 1e-3)
        assert np.all(np.abs(found - truth) < 4.0 * errors)
        assert errors[0] < 0.01 * truth[0]
        assert errors[1] < 0.02
