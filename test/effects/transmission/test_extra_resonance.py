"""The extra mode against linear theory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete, lfilter

from microgripper_control.core.signals import POSITION, Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

Alone = Callable[..., Array]
every_share = pytest.mark.parametrize("share", [-0.5, 0.2, 1.0, 2.0])


def mode(share: float, frequency: float, damping: float) -> tuple[list[float], list[float]]:
    """Transfer function from x to the finger."""
    omega = 2.0 * np.pi * frequency
    rest = 1.0 - share
    numerator = [omega**2] if rest == 0.0 else [rest, rest * 2.0 * damping * omega, omega**2]
    return numerator, [1.0, 2.0 * damping * omega, omega**2]


@every_share
def test_alone_it_is_exact(alone: Alone, share: float) -> None:
    values = {"share": share, "frequency": 180.0, "damping": 0.03}
    x = np.random.default_rng(5).normal(size=300).cumsum()
    x[0] = 0.0
    out = alone("extra_resonance", values, x, (0.4e-3,), row=POSITION, ramped=True)
    numerator, denominator, _ = cont2discrete(mode(**values), 0.4e-3, "foh")
    np.testing.assert_allclose(out, lfilter(numerator[0], denominator, x), atol=1e-9)


def test_two_modes_add_up(alone: Alone) -> None:
    first = {"share": 0.2, "frequency": 180.0, "damping": 0.03}
    second = {"share": -0.1, "frequency": 260.0, "damping": 0.02}
    x = np.random.default_rng(6).normal(size=300).cumsum()
    x[0] = 0.0
    out, one, other = (
        alone("extra_resonance", values, x, (0.4e-3,), row=POSITION, ramped=True)
        for values in (
            first | {"second": -0.1, "second_frequency": 260.0, "second_damping": 0.02},
            first,
            second,
        )
    )
    np.testing.assert_allclose(out - x, (one - x) + (other - x), atol=1e-12)


def test_what_two_modes_can_add_to_a_loop_is_what_both_can(paper: Model) -> None:
    first, second = (0.2, 180.0, 0.03), (-0.1, 260.0, 0.02)
    names, others = (
        ("share", "frequency", "damping"),
        ("second", "second_frequency", "second_damping"),
    )
    one, other = (
        paper.with_link("extra_resonance", **dict(zip(names, mode, strict=True))).ringing
        for mode in (first, second)
    )
    both = dict(zip(names, first, strict=True)) | dict(zip(others, second, strict=True))
    assert paper.with_link("extra_resonance", **both).ringing == pytest.approx(one + other)


@pytest.mark.parametrize(("drag", "hardening"), [(3e4, 0.0), (0.0, 4e10), (2e4, -2e10)])
def test_drag_and_hardening_against_an_integrator(
    alone: Alone, drag: float, hardening: float
) -> None:
    """Steps of 2 um to a mode of 40 Hz."""
    step, omega = 0.25e-3, 2.0 * np.pi * 40.0
    time = step * np.arange(2000)
    x = 2e-6 * np.interp(time, [0.0, 0.002, 0.2, 0.202], [0.0, 1.0, 1.0, 0.0])

    def law(t: float, state: Array) -> list[float]:
        q, v = state
        away = q - np.interp(t, time, x)
        pull = omega**2 * (1.0 + hardening * away**2) * away
        return [v, -(2.0 * 0.01 * omega + drag * abs(v)) * v - pull]

    exact = solve_ivp(law, time[[0, -1]], [0.0, 0.0], t_eval=time, rtol=1e-9, max_step=step)
    values = {"share": 1.0, "frequency": 40.0, "damping": 0.01}
    found, linear = (
        alone("extra_resonance", values | more, x, (step,), row=POSITION, ramped=True)
        for more in ({"drag": drag, "hardening": hardening}, {})
    )
    assert np.std(found - exact.y[0]) < 0.02 * np.std(linear - exact.y[0])


@pytest.mark.parametrize("further", [{"drag": 1e4}, {"hardening": 2e8}])
@pytest.mark.parametrize("frequency", [120.0, 350.0, 450.0])
def test_drag_and_hardening_do_not_depend_on_the_sampling(
    paper: Model,
    lively: Array,
    finely: Callable[[Model, Array, float], Array],
    frequency: float,
    further: dict[str, float],
) -> None:
    mode = {"share": 0.2, "frequency": frequency, "damping": 0.02}
    model = paper.with_link("extra_resonance", **mode, **further)
    exact = finely(model, lively, 1e-3)
    without = simulate(paper.with_link("extra_resonance", **mode), lively, 1e-3)
    error = np.linalg.norm(simulate(model, lively, 1e-3) - exact)
    assert error < 0.05 * np.linalg.norm(without - exact)


@every_share
@pytest.mark.parametrize("frequency", [60.0, 350.0, 800.0])
@pytest.mark.parametrize("rig", ["paper", "slow"])
def test_behind_the_mechanics_it_meets_theory(
    rig: str,
    request: pytest.FixtureRequest,
    without_hysteresis: Callable[[Model], Model],
    filtered: Callable[..., Array],
    lively: Array,
    share: float,
    frequency: float,
) -> None:
    linear = without_hysteresis(request.getfixturevalue(rig))
    values = {"share": share, "frequency": frequency, "damping": 0.02}
    expected = filtered(linear, lively, mode(**values))
    found = simulate(linear.with_link("extra_resonance", **values), lively, 1e-3)
    absent = simulate(linear, lively, 1e-3)
    assert np.linalg.norm(found - expected) < 0.02 * np.linalg.norm(absent - expected)


def test_the_gain_at_rest_stays_one(paper: Model) -> None:
    settled = np.full(50, 90.0)
    expected = simulate(paper, settled, 1e-3, initial=Initial.FIRST_SAMPLE)
    model = paper.with_link("extra_resonance", share=1.0)
    found = simulate(model, settled, 1e-3, initial=Initial.FIRST_SAMPLE)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_it_rings_at_its_frequency_and_dies_away_as_damped(paper: Model) -> None:
    model = paper.with_link("extra_resonance", share=0.3, frequency=100.0, damping=0.05)
    u = np.full(2000, 60.0)
    ring = (simulate(model, u, 2e-4) - simulate(paper, u, 2e-4))[50:1000]
    peaks = 50 + np.flatnonzero((ring[1:-1] > ring[:-2]) & (ring[1:-1] > ring[2:])) + 1
    period = 2e-4 * np.diff(peaks).mean()
    assert period == pytest.approx(1.0 / (100.0 * np.sqrt(1.0 - 0.05**2)), rel=5e-3)
    decay = np.log(ring[peaks[0] - 50] / ring[peaks[4] - 50]) / 4.0
    assert decay == pytest.approx(2.0 * np.pi * 0.05 / np.sqrt(1.0 - 0.05**2), rel=0.02)


@pytest.mark.parametrize("truth", [[0.15, 140.0, 0.03], [-0.1, 310.0, 0.06]])
def test_a_planted_mode_is_found(
    paper: Model,
    lively: Array,
    recover: Callable[..., tuple[Array, Array]],
    truth: list[float],
) -> None:
    names = ("share", "frequency", "damping")
    rig = paper.with_link("extra_resonance", **dict(zip(names, truth, strict=True)))
    start = {"share": 0.7 * truth[0], "frequency": 1.03 * truth[1], "damping": 0.04}
    found, errors = recover(rig, "extra_resonance", start, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.02 * np.abs(truth))
