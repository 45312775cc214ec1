"""The slew limit against closed forms and a naive integration in small steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Scales
from microgripper_control.effects.drive.slew_limit import late_after, starts
from microgripper_control.effects.registry import link_named
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

RISE, FALL = 2e-4, 5e-4  # s/V
LIMITS = {"time": 3.5e-4, "asymmetry": -1.5 / 3.5}
STEPS = (0.1e-3, 0.35e-3, 0.05e-3, 0.5e-3)  # s
Alone = Callable[..., Array]


def test_a_jump_becomes_a_ramp(alone: Alone) -> None:
    up = alone("slew_limit", LIMITS, np.full(80, 50.0), STEPS)
    t = np.cumsum(np.resize(STEPS, 80))
    np.testing.assert_allclose(up, np.minimum(t / RISE, 50.0), rtol=1e-12)
    down = alone("slew_limit", LIMITS, np.full(160, 0.0), STEPS, level=50.0)
    t = np.cumsum(np.resize(STEPS, 160))
    np.testing.assert_allclose(down, np.maximum(50.0 - t / FALL, 0.0), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("ramped", "growth"), [(False, 0.0), (True, 0.0), (False, 0.01), (True, 0.01)]
)
def test_any_input_is_followed_as_fast_as_allowed(
    alone: Alone, ramped: bool, growth: float
) -> None:
    """The rule itself, in steps a thousand times smaller."""
    signal = np.random.default_rng(2).normal(scale=3.0, size=300).cumsum()
    small, step = 1000, 5e-4
    dt = step / small
    y, old, expected = 0.0, 0.0, []
    for new in signal:
        for i in range(1, small + 1):
            goal = old + (new - old) * i / small if ramped else new
            easier = np.exp(-growth * y)
            y += min(max(goal - y, -dt / FALL * easier), dt / RISE * easier)
        expected.append(y)
        old = new
    out = alone("slew_limit", LIMITS | {"growth": growth}, signal, (step,), ramped=ramped)
    straight = growth * np.max(np.abs(np.diff(signal))) ** 2 / 8.0 if ramped else 0.0  # in charge
    np.testing.assert_allclose(out, expected, atol=3.0 * dt / RISE + straight)
    assert np.std(out - signal) > 0.3  # it did limit


@pytest.mark.parametrize("lag", [0.03, 0.4, 7.0])
def test_a_regulated_output_is_that_of_its_equation(lag: float) -> None:
    """Late, in V; limits and slope in V a step: against `solve_ivp`, whatever is limited."""
    random = np.random.default_rng(4)
    up, down = 1.7, 0.6
    for late, run in random.normal(scale=(3.0, 2.0), size=(40, 2)):
        start = late * (lag if random.random() < 0.5 else 1.0)  # regulated, or beyond it

        def change(_: float, e: Array, run: float = run) -> Array:
            return run - np.clip(e / lag, -down, up)

        found = solve_ivp(change, (0.0, 1.0), [start], rtol=1e-9, atol=1e-11, max_step=0.02)
        assert late_after(start, run, up, down, lag) == pytest.approx(found.y[0, -1], abs=1e-6)


def test_what_is_no_number_stays_none() -> None:
    """A fit may go where nothing is finite; it must come to an end all the same."""
    numbers = (0.0, 0.3, -4.0, math.inf, -math.inf, math.nan)
    for late, run, up, down, lag in product(numbers, numbers, *(numbers[:2] + numbers[3:],) * 3):
        if min(up, down, lag) >= 0.0 or math.isnan(up + down + lag):
            late_after(late, run, up, down, lag)
    assert math.isnan(late_after(math.nan, 1.0, 1.0, 1.0, 0.5))
    assert math.isnan(late_after(1.0, math.nan, 1.0, 1.0, 0.5))
    assert math.isnan(late_after(math.nan, 1.0, 1.0, 1.0, 0.0))


def test_a_soft_knee_settles_exponentially(alone: Alone) -> None:
    """50 V at 5000 V/s until 2 V are left; from then on with a time constant of 0.4 ms."""
    t = np.cumsum(np.resize(STEPS, 80))
    settling = 50.0 - 2.0 * np.exp(-(t - 48.0 * RISE) / (2.0 * RISE))
    out = alone("slew_limit", {"time": RISE, "knee": 2.0}, np.full(80, 50.0), STEPS)
    np.testing.assert_allclose(out, np.where(t < 48.0 * RISE, t / RISE, settling), rtol=1e-12)


@pytest.mark.parametrize("growth", [0.006, -0.004])
def test_a_capacitance_that_grows_slows_what_is_high(alone: Alone, growth: float) -> None:
    """i = C0 e^(growth u) du/dt: a closed form upwards and, from 100 V, down."""
    t = np.cumsum(np.resize(STEPS, 200))
    limits = LIMITS | {"growth": growth}
    rising = np.log(np.maximum(1.0 + growth * t / RISE, 1e-3)) / growth
    full = RISE * np.expm1(100.0 * growth) / growth
    up = alone("slew_limit", limits, np.full(200, 100.0), STEPS)
    np.testing.assert_allclose(up, np.where(t < full, rising, 100.0), rtol=1e-12)
    falling = np.log(np.maximum(np.exp(100.0 * growth) - growth * t / FALL, 1e-3)) / growth
    down = alone("slew_limit", limits, np.full(200, 0.0), STEPS, level=100.0)
    np.testing.assert_allclose(down, np.maximum(falling, 0.0), rtol=1e-12, atol=1e-11)


def test_one_way_can_be_free(alone: Alone) -> None:
    signal = np.array([10.0, 10.0, -10.0, -10.0])
    out = alone("slew_limit", {"time": 5e-4, "asymmetry": -1.0}, signal, (5e-3,))
    np.testing.assert_allclose(out, [10.0, 10.0, 5.0, 0.0])


def test_what_is_slow_enough_passes(alone: Alone) -> None:
    signal = np.linspace(0.0, 1.0, 100)
    out = alone("slew_limit", LIMITS, signal, (1e-3,), ramped=True)
    np.testing.assert_allclose(out, signal, rtol=1e-12)


def test_large_steps_show_it_and_small_ones_do_not(paper: Model) -> None:
    """At 40 us/V this rig rests again within a sample from up to 20 V."""
    model = paper.with_link("slew_limit", time=4e-5)
    for height, seen in ((15.0, False), (80.0, True)):
        u = np.repeat([0.0, height, 0.0], 50)
        difference = np.max(np.abs(simulate(model, u, 1e-3) - simulate(paper, u, 1e-3)))
        assert difference > 1e-6 if seen else difference < 1e-9


def test_the_corner_is_drawn_finely_enough(
    slow: Model, lively: Array, finely: Callable[[Model, Array, float], Array]
) -> None:
    absent = simulate(slow, lively, 1e-3)
    for limit, knee in product((1e-6, 1e-5, 4e-5, 2e-4), (0.0, 1.5)):
        model = slow.with_link("slew_limit", time=limit, knee=knee)
        expected = finely(model, lively, 1e-3)
        error = np.linalg.norm(simulate(model, lively, 1e-3) - expected)
        assert error < 0.03 * np.linalg.norm(absent - expected)


@pytest.mark.parametrize(
    ("further", "sure"),
    [({}, 0.003), ({"growth": (4e-3, 1e-3)}, 0.01), ({"knee": (0.8, 0.1)}, 0.1)],
)
def test_a_planted_limit_is_found(
    paper: Model,
    lively: Array,
    further: dict[str, tuple[float, float]],
    sure: float,
    recover: Callable[..., tuple[Array, Array]],
) -> None:
    planted = {"time": (8e-5, 6e-5), "asymmetry": (-0.3, 0.1)} | further
    truth = {name: value for name, (value, _) in planted.items()}
    start = {name: guess for name, (_, guess) in planted.items()}
    rig = paper.with_link("slew_limit", **truth)
    found, errors = recover(rig, "slew_limit", start, lively, 1e-3)
    values = np.array([*truth.values()])
    assert np.all(np.abs(found - values) < 4.0 * errors)
    assert np.all(errors < sure * np.abs(values))


def test_limits_that_only_round_a_jump_are_guessed_as_well() -> None:
    """150 V within a sample of 1 ms: at 450 V/ms the mass is thrown less far than by a jump."""
    fastest = 150.0 / 1e-3
    scales = Scales(1e-3, 10.0, (0.0, 150.0), fastest, (0.0, 1e-4), 5e7, 0.0038)
    limits = [1.0 / guess["time"] for guess in starts(scales) if "asymmetry" not in guess]
    assert min(limits) < 0.05 * fastest
    assert max(limits) > 3.0 * fastest


@pytest.mark.parametrize(
    ("asymmetry", "growth", "told"),
    [
        (0.0, 0.0, "the voltage rises by 10000 V/s at most and falls by 10000 V/s at most"),
        (-1.0, 0.0, "the voltage falls by 5000 V/s at most"),
        (-0.999, 0.002, "the voltage falls by 5000 V/s at most at 0 V, and less above"),
        (0.999, -0.002, "the voltage rises by 5000 V/s at most at 0 V, and more above"),
    ],
)
def test_it_says_what_is_limited(paper: Model, asymmetry: float, growth: float, told: str) -> None:
    scales = Scales(1e-3, 10.0, (0.0, 150.0), 2e4, (0.0, 1e-4), 5e7, 0.0038)
    link = link_named("slew_limit")
    values = {"time": 1e-4, "asymmetry": asymmetry, "growth": growth, "knee": 0.0}
    assert link.says is not None
    said = link.says(paper.with_link("slew_limit", **values).values("slew_limit"), scales)
    assert said == f"the amplifier is short of current: {told}"
