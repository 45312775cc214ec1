"""The hysteresis against its own equation, its limits and its invariances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.effects.material.bouc_wen import advance, slope
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate


def integrated(g: float, xi: float, beta: float, gamma: float, n: float) -> float:
    """dg/dxi of the unit equation (a = 1) over xi, stopped and restarted where g passes zero."""

    def rate(_: float, y: list[float]) -> list[float]:
        return [1.0 - beta * y[0] * abs(y[0]) ** (n - 1.0) - gamma * abs(y[0]) ** n]

    def zero(_: float, y: list[float]) -> float:
        return y[0]

    zero.terminal, zero.direction = True, 1.0  # type: ignore[attr-defined]
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-15}
    solved = solve_ivp(rate, (0.0, xi), [g], events=zero if g < 0.0 else None, **options)
    if solved.status == 1:
        solved = solve_ivp(rate, (solved.t[-1], xi), [0.0], **options)
    return float(solved.y[0, -1])


@pytest.mark.parametrize("n", [1.0, 1.001, 1.2, 1.5, 2.0, 3.0, 5.0])
def test_it_solves_its_equation(n: float) -> None:
    """Whatever the signs of beta and gamma, from below zero and above, over short ways and long."""
    rng = np.random.default_rng(5)
    worst = 0.0
    for _ in range(40):
        above, below = rng.uniform(-0.8, 3.0, 2)
        beta, gamma = (above + below) / 2.0, (above - below) / 2.0
        g, xi = rng.uniform(-1.2, 0.9), 10.0 ** rng.uniform(-3.0, 0.0)
        expected = integrated(g, xi, beta, gamma, n)
        if abs(expected) < 3.0:
            worst = max(worst, abs(advance(g, xi, 1.0, beta, gamma, n) - expected))
    assert worst < (1e-11 if n in (1.0, 2.0) else 5e-8)


def test_at_n_2_it_saturates_as_a_hyperbolic_tangent() -> None:
    for xi in (0.1, 1.0, 4.0):
        assert advance(0.0, xi, 1.0, 0.7, 0.3, 2.0) == pytest.approx(math.tanh(xi), abs=1e-14)


@pytest.mark.parametrize("n", [1.0, 1.5, 2.0])
def test_the_other_way_is_the_mirror_image(n: float) -> None:
    for h, du in ((0.3, 0.2), (-0.5, 0.9), (0.0, 2.0)):
        there = advance(h, du, 1.0, 0.4, -0.6, n)
        assert advance(-h, -du, 1.0, 0.4, -0.6, n) == -there


@pytest.mark.parametrize(("n", "tolerance"), [(1.0, 1e-13), (1.5, 1e-8), (2.0, 1e-13)])
def test_one_long_step_is_many_short_ones(n: float, tolerance: float) -> None:
    for h in (-0.8, 0.0, 0.4):
        parts = h
        for _ in range(1000):
            parts = advance(parts, 1e-3, 1.0, 1.3, -0.4, n)
        assert parts == pytest.approx(advance(h, 1.0, 1.0, 1.3, -0.4, n), abs=tolerance)


def test_its_bound_is_never_passed() -> None:
    bound = (1.0 / (1.3 - 0.4)) ** (1.0 / 1.5)
    assert advance(0.0, 1e4, 1.0, 1.3, -0.4, 1.5) == pytest.approx(bound, rel=1e-9)


@pytest.mark.parametrize("n", [1.0, 2.0])
def test_n_just_above_is_nearly_the_closed_form(n: float) -> None:
    for h, du in ((-0.4, 1.0), (0.2, 0.5)):
        closed = advance(h, du, 1.0, 1.3, -0.4, n)
        assert advance(h, du, 1.0, 1.3, -0.4, n + 1e-9) == pytest.approx(closed, abs=1e-8)


@pytest.mark.parametrize("n", [2.0, 2.5])
@pytest.mark.parametrize("start", [-0.4, 0.0, 0.6])
def test_growth_without_bound_ends_in_infinity_not_in_a_hang(n: float, start: float) -> None:
    assert not math.isfinite(advance(start, 1e3, 1.0, -2.0, -1.0, n))


def test_the_slope_is_the_derivative() -> None:
    for g in (-0.7, 0.3):
        difference = advance(g, 1e-6, 1.0, 1.3, -0.4, 1.5) - g
        assert difference / 1e-6 == pytest.approx(slope(g, 1.0, 1.3, -0.4, 1.5), rel=1e-5)


def test_it_knows_the_way_not_the_speed(paper: Model) -> None:
    """Slow against the mechanics, a cycle of any duration draws the same loop."""
    u = 80.0 - 80.0 * np.cos(np.arange(500) / 40.0)
    quick = simulate(paper, u, 1e-2, hold=Hold.FIRST)
    slow = simulate(paper, u, 1.0, hold=Hold.FIRST)
    np.testing.assert_allclose(quick, slow, rtol=0.0, atol=1e-5 * np.ptp(slow))


def test_the_paper_s_figures(paper: Model) -> None:
    """19.2 um at 160 V on the first rise; loops 8.8 % wide at first, then 4.3 %."""
    rise = np.linspace(0.0, 160.0, 2001)
    cycle = np.concatenate([rise, rise[-2::-1]])
    u = np.concatenate([cycle, *(cycle[1:] for _ in range(5))])
    x = simulate(paper, u, 1e-3, hold=Hold.FIRST)
    assert x[2000] == pytest.approx(19.2e-6, rel=0.005)
    widths = []
    for first in (0, 4000 * 5):
        up, down = x[first : first + 2001], x[first + 2000 : first + 4001][::-1]
        widths.append(np.max(down - up) / np.ptp(x[first : first + 4001]))
    assert widths[0] == pytest.approx(0.088, abs=0.002)
    assert widths[1] == pytest.approx(0.043, abs=0.002)
    assert 1.5e-6 < x[-1] < 1.9e-6
