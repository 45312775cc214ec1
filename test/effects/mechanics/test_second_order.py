"""The linear mechanics against closed forms and scipy's discretisation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from microgripper_control.core.signals import FREE, LEVELS, POSITION, ROWS, Array, Timing
from microgripper_control.effects.mechanics.second_order import LINK, static_gain
from microgripper_control.plant.model import Model

Values = dict[str, float]


def follow(values: Values, w: Array, steps: tuple[float, ...], ramped: bool = False) -> Array:
    """Positions at the ends of the steps, from rest at w = 0."""
    prepared = LINK.prepare(values, Timing(sum(steps), steps, ramped), np.zeros(LEVELS))
    bus = np.zeros((ROWS, len(w)))
    bus[FREE] = w
    LINK.kernel(prepared.coefficients, prepared.state, bus)
    return bus[POSITION]


def step_response(values: Values, t: Array) -> Array:
    omega = np.sqrt((values["k"] + values["k_s"]) / values["m"])
    zeta = values["b"] / (2.0 * values["m"] * omega)
    root = np.sqrt(complex(1.0 - zeta**2))
    ringing = np.cos(root * omega * t) + zeta / root * np.sin(root * omega * t)
    response: Array = static_gain(values) * np.real(1.0 - np.exp(-zeta * omega * t) * ringing)
    return response


@pytest.mark.parametrize("damping", [0.0, 1.0, 7.0, 40.0])
def test_a_held_step_rings_as_theory_says(paper: Model, damping: float) -> None:
    values = paper.values("second_order")
    values["b"] *= damping
    steps = (3e-6, 20e-6, 7e-6)
    t = np.cumsum(np.resize(steps, 90))
    found = follow(values, np.ones(90), steps)
    np.testing.assert_allclose(found, step_response(values, t), rtol=0.0, atol=1e-11)


@pytest.mark.parametrize(("ramped", "method"), [(False, "zoh"), (True, "foh")])
@pytest.mark.parametrize("rig", ["paper", "slow"])
def test_any_input_is_followed_exactly(
    rig: str, ramped: bool, method: str, request: pytest.FixtureRequest
) -> None:
    model: Model = request.getfixturevalue(rig)
    values = model.values("second_order")
    w = np.append(0.0, np.random.default_rng(0).normal(size=300))
    for step in (1e-5, 2e-4, 1e-3):
        system = ([values["k"]], [values["m"], values["b"], values["k"] + values["k_s"]])
        numerator, denominator, _ = cont2discrete(system, step, method)
        expected = lfilter(numerator[0], denominator, w)
        found = follow(values, w, (step,), ramped)
        # Ours is the position at the end of a step, scipy's is the one at the sample.
        pair = (found, expected) if ramped else (found[:-1], expected[1:])
        np.testing.assert_allclose(*pair, rtol=0.0, atol=1e-7)


def test_a_step_of_no_duration_changes_nothing(paper: Model) -> None:
    w = np.repeat(np.random.default_rng(0).normal(size=20), 2)
    whole = follow(paper.values("second_order"), w[::2], (5e-6,))
    split = follow(paper.values("second_order"), w, (0.0, 5e-6))
    np.testing.assert_array_equal(split[1::2], whole)


@pytest.mark.parametrize("ramped", [False, True])
@pytest.mark.parametrize("damping", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("span", [1.01, 3.0, 100.0])
def test_the_difference_equation_is_the_map(
    paper: Model, span: float, damping: float, ramped: bool
) -> None:
    """Steps that are all alike and long are taken without the velocity, a divided one with it."""
    values = paper.values("second_order")
    values["b"] *= damping
    step = span * np.sqrt(values["m"] / (values["k"] + values["k_s"]))
    w = np.repeat(np.random.default_rng(0).normal(size=2000), 2)
    whole = follow(values, w[1::2], (step,), ramped)
    if ramped:
        w = np.append(0.0, w[:-1])  # what has no duration does not move it
    split = follow(values, w, (0.0, step), ramped)
    np.testing.assert_allclose(split[1::2], whole, rtol=0.0, atol=1e-12)


def test_at_rest_it_is_the_springs_gain(paper: Model, slow: Model) -> None:
    for model in (paper, slow):
        values = model.values("second_order")
        values["b"] *= 10.0
        found = follow(values, np.ones(200), (1e-3,))
        assert found[-1] == pytest.approx(static_gain(values), rel=1e-12)


def test_settling_follows_the_ringing_to_its_end(slow: Model) -> None:
    """Corners at least at each turn of it, none when it has died away."""
    values = slow.values("second_order")
    corners = sorted(LINK.settling(values, 1e-3))
    swings = 2.0 * 1300.0 * 1e-3
    assert len(corners) > 2.0 * swings
    values["b"] *= 40.0
    assert max(LINK.settling(values, 1.0)) < 0.01


def test_planted_mass_and_damping_are_found(
    slow: Model, recover: Callable[..., tuple[Array, Array]]
) -> None:
    """Where the sampling resolves the resonance."""
    values = slow.values("second_order")
    u = np.repeat(np.random.default_rng(3).uniform(0.0, 160.0, 10), 100)
    start = {"m": 1.02 * values["m"], "b": 0.8 * values["b"]}
    found, errors = recover(slow, "second_order", start, u, 5e-5)
    truth = np.array([values["m"], values["b"]])
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 1e-2 * truth)
