"""Hysteresis in the restoring force against its family, an integrator and the public benchmark."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.signals import Array
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Hold, simulate

LINK = "restoring_force_hysteresis"

# The public Bouc-Wen benchmark: mL y'' + cL y' + kL y + z = u.
MASS, DAMPING, STIFFNESS = 2.0, 10.0, 5e4
ALPHA, BETA, GAMMA = 5e4, 1e3 * 0.8, 1e3 * -1.1
RATE = 750.0  # Hz


@pytest.fixture
def benchmark(paper: Model) -> Model:
    """The benchmark's oscillator; one volt is one newton."""
    mechanics = {"m": MASS, "b": DAMPING, "k": STIFFNESS, "k_s": 0.0}
    values = {("second_order", name): value for name, value in mechanics.items()}
    values |= {("bouc_wen", "d"): 1.0 / STIFFNESS, ("bouc_wen", "alpha"): 0.0}
    return paper.with_values(values).with_link(LINK, alpha=ALPHA, beta=BETA, gamma=GAMMA, n=1.0)


@pytest.fixture
def multisine() -> Array:
    """5 to 150 Hz, 50 N rms, from 0 N, 0.8 s."""
    rng = np.random.default_rng(0)
    t = np.arange(600) / RATE
    lines = np.arange(5.0, 150.0, 2.0)
    phases = rng.uniform(0.0, 2.0 * np.pi, len(lines))
    u = np.cos(2.0 * np.pi * lines[:, None] * t + phases[:, None]).sum(axis=0)
    u *= 50.0 / np.std(u)
    return np.append(0.0, u[1:])


def integrated(u: Array, hold: Hold) -> Array:
    """The benchmark's equations as its authors write them."""

    def rates(t: float, y: Array, old: float, rate: float) -> list[float]:
        x, v, z = y
        fading = BETA * abs(v) * z + GAMMA * v * abs(z)
        acceleration = (old + rate * t - DAMPING * v - STIFFNESS * x - z) / MASS
        return [v, acceleration, ALPHA * v - fading]

    y, positions = np.zeros(3), [0.0]
    for old, new in pairwise(u):
        rate = (new - old) * RATE if hold is Hold.FIRST else 0.0
        options = {"rtol": 1e-9, "atol": [1e-12, 1e-9, 1e-7], "args": (old, rate)}
        y = solve_ivp(rates, (0.0, 1.0 / RATE), y, "DOP853", **options).y[:, -1]
        positions.append(y[0])
    return np.array(positions)


@pytest.mark.parametrize("hold", [Hold.ZERO, Hold.FIRST])
def test_the_public_benchmark(benchmark: Model, multisine: Array, hold: Hold) -> None:
    expected = integrated(multisine, hold)
    found = simulate(benchmark, multisine, 1.0 / RATE, hold=hold)
    assert np.std(expected) > 4e-4
    assert np.sqrt(np.mean((found - expected) ** 2)) < 1e-7
    linear = simulate(benchmark.without([LINK]), multisine, 1.0 / RATE, hold=hold)
    assert np.std(linear - expected) > 1e-4


def test_slowly_z_is_the_family_s_z(paper: Model) -> None:
    alpha, beta, gamma = 3e6, 9e4, -3e4
    s = paper.values("second_order")
    linear = paper.with_values({("bouc_wen", "alpha"): 0.0})
    voltage = 80.0 - 80.0 * np.abs(1.0 - np.arange(3001) / 500.0 % 2.0)
    model = linear.with_link(LINK, alpha=alpha, beta=beta, gamma=gamma)
    x = simulate(model, voltage, 10.0, hold=Hold.FIRST)
    z, forces = 0.0, [0.0]
    for way in np.diff(x):
        z = advance(z, float(way), alpha, beta, gamma, 1.0)
        forces.append(z)
    pull = s["k"] * linear.value("bouc_wen", "d") * voltage - (s["k"] + s["k_s"]) * x
    np.testing.assert_allclose(pull, forces, rtol=0.0, atol=1e-6 * np.max(forces))


@pytest.mark.parametrize("n", [1.5, 2.0])
def test_any_exponent(benchmark: Model, multisine: Array, n: float) -> None:
    u = multisine[:200]
    scale = 30.0 ** (1.0 - n)  # so that z saturates at a like level
    beta, gamma = BETA * scale, 300.0 * scale
    model = benchmark.with_link(LINK, alpha=ALPHA, beta=beta, gamma=gamma, n=n)

    def rates(t: float, y: Array, old: float) -> list[float]:
        x, v, z = y
        fading = beta * abs(v) * abs(z) ** (n - 1.0) * z + gamma * v * abs(z) ** n
        return [v, (old - DAMPING * v - STIFFNESS * x - z) / MASS, ALPHA * v - fading]

    y, expected = np.zeros(3), [0.0]
    for old in u[:-1]:
        options = {"rtol": 1e-9, "atol": [1e-12, 1e-9, 1e-7], "args": (old,)}
        y = solve_ivp(rates, (0.0, 1.0 / RATE), y, "DOP853", **options).y[:, -1]
        expected.append(y[0])
    error = simulate(model, u, 1.0 / RATE) - expected
    assert np.sqrt(np.mean(error**2)) < 1e-7


@pytest.mark.parametrize(
    ("rig", "alpha", "gamma", "tolerance"),
    [
        ("paper", 0.04, 2e4, 0.015),
        ("paper", 0.5, -1.3e5, 0.04),
        ("slow", 0.04, 2e4, 1e-3),
        ("slow", 0.5, -1.3e5, 2e-3),
    ],
)
def test_it_meets_an_integrator(
    rig: str,
    alpha: float,
    gamma: float,
    tolerance: float,
    agreement: Callable[..., list[float]],
    request: pytest.FixtureRequest,
) -> None:
    model: Model = request.getfixturevalue(rig)
    beta = 1e5
    values = {"alpha": alpha * model.value("second_order", "k"), "beta": beta, "gamma": gamma}

    def force(x: float, v: float, own: Array) -> tuple[float, list[float]]:
        (z,) = own
        return -z, [values["alpha"] * v - beta * abs(v) * z - gamma * v * abs(z)]

    assert max(agreement(model, LINK, values, force, 1)) < tolerance


def test_planted_values_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = np.array([4e6, 8e4, 3e4])
    rig = paper.with_link(LINK, alpha=truth[0], beta=truth[1], gamma=truth[2])
    start = {"alpha": 2e6, "beta": 1e5, "gamma": 2e4}
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert errors[0] < 0.1 * truth[0]
