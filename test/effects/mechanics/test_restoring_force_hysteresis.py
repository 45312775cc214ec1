"""Hysteresis in the restoring force against closed forms, an integrator, the public benchmark."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Scales, Values
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.effects.mechanics.restoring_force_hysteresis import (
    law,
    memory,
    rescaled,
)
from microgripper_control.effects.registry import link_named
from microgripper_control.effects.slipping_springs import SPRINGS
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

LINK = "restoring_force_hysteresis"
SCALES = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (0.0, 2e-5), 5e7, 0.0038)

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


def asked(values: Values, places: Array) -> Array:
    """The law's force, N, at each of some places that the mass goes to one after the other, m."""
    link = link_named(LINK)
    assert link.force is not None
    given = {p.name: p.nominal for p in link.parameters} | dict(values)
    c, state = np.array(link.force.coefficients(given)), np.zeros(link.force.states)
    return np.array([law(c, state, state, *way, 0.0, 1e-3) for way in pairwise(places)])


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


def test_sharp_first_guesses_remember_as_far_as_they_were_meant_to(paper: Model) -> None:
    """Those of exponent 2: over the stroke, half of it and so on to a sixteenth."""
    ways = set()
    for start in link_named(LINK).starts(SCALES):
        values = paper.with_link(LINK, **start).values(LINK)
        if values["n"] == 2.0:
            ways.add(round(memory(values) / SCALES.stroke, 9))
    assert ways == {1.0, 0.5, 0.25, 0.125, 0.0625}


SLIPPING = {"alpha": 4e6, "distributed": 1.0, "widest": 8e-6}


@pytest.mark.parametrize(
    ("spread", "wider", "decades", "taper", "stiffer"),
    [
        (0.5, 0.947, 0.810, -1.926, 0.989),
        (1.0, 0.927, 1.120, -0.943, 0.951),
        (2.0, 0.910, 1.399, -0.451, 0.842),
    ],
)
def test_bit_by_bit_it_softens_as_a_power_law_has_it(
    spread: float, wider: float, decades: float, taper: float, stiffer: float
) -> None:
    """Distances W q^spread, q evenly from 0 to 1: Iwan 1966 (spread 1) and Segalman 2005.

    Their first loading is alpha int_0^1 min(x, W q^spread) dq; the springs' values are those that
    follow it best, by least squares over this curve.
    """
    widest, alpha = SLIPPING["widest"], SLIPPING["alpha"]
    x = np.linspace(0.0, 1.2 * widest, 241)
    slipped = np.minimum(x / widest, 1.0) ** (1.0 / spread)
    force = alpha * (widest * slipped ** (spread + 1.0) / (spread + 1.0) + x * (1.0 - slipped))
    values = {"alpha": stiffer * alpha, "widest": wider * widest, "decades": decades}
    error = asked(SLIPPING | values | {"taper": taper}, x) + force[1:]
    assert np.max(np.abs(error)) < 2.5e-3 * alpha * widest


def test_a_reversal_is_the_first_loading_twice_as_large() -> None:
    """Masing's rule; and the turned-at point is met again, after which nothing remembers it."""
    up, down = np.linspace(0.0, 6e-6, 61), np.linspace(6e-6, 1e-6, 51)
    again = np.linspace(1e-6, 9e-6, 81)
    force = np.append(0.0, asked(SLIPPING, np.concatenate([up, down[1:], again[1:]])))
    first = np.append(0.0, asked(SLIPPING, np.linspace(0.0, 9e-6, 91)))
    back = force[60:111] - force[60]
    half = np.append(0.0, asked(SLIPPING, np.linspace(0.0, 2.5e-6, 51)))
    np.testing.assert_allclose(back, -2.0 * half, atol=1e-9)
    np.testing.assert_allclose(force[-31:], first[-31:], atol=1e-9)


def test_undistributed_it_is_bouc_wen(paper: Model, lively: Array) -> None:
    plain = simulate(paper.with_link(LINK), lively, 1e-3)
    wide = simulate(paper.with_link(LINK, distributed=0.0, widest=1e-6), lively, 1e-3)
    np.testing.assert_array_equal(wide, plain)
    absent = simulate(paper, lively, 1e-3)
    errors = []
    for share in (1e-3, 1e-6):
        found = simulate(paper.with_link(LINK, distributed=share), lively, 1e-3)
        errors.append(np.max(np.abs(found - plain)) / np.max(np.abs(absent - plain)))
    assert errors[0] < 0.02
    assert errors[1] < 2e-3 * errors[0]


@pytest.mark.parametrize(
    ("rig", "alpha", "tolerance"),
    [("paper", 0.1, 0.02), ("slow", 0.1, 5e-3)],
)
def test_slipping_bit_by_bit_it_meets_an_integrator(
    rig: str,
    alpha: float,
    tolerance: float,
    agreement: Callable[..., list[float]],
    request: pytest.FixtureRequest,
) -> None:
    model: Model = request.getfixturevalue(rig)
    beta, gamma, distributed = 2e5, 1e5, 0.7
    alpha *= model.value("second_order", "k")
    values = {"alpha": alpha, "beta": beta, "gamma": gamma}
    values |= {"distributed": distributed, "widest": 1.5e-5, "decades": 0.8, "taper": -1.0}
    limits = 1.5e-5 * np.geomspace(1.0, 10.0**-0.8, SPRINGS)
    bit = alpha * distributed * limits / np.sum(limits)  # N/m, each as stiff as it goes far

    def force(x: float, v: float, own: Array) -> tuple[float, list[float]]:
        z, pulls = own[0], own[1:]
        slips = (np.abs(pulls) >= bit * limits) & (pulls * v > 0.0)
        fading = beta * abs(v) * z + gamma * v * abs(z)
        rates = [alpha * (1.0 - distributed) * v - fading, *np.where(slips, 0.0, bit * v)]
        return -float(np.sum(own)), rates

    assert max(agreement(model, LINK, values, force, 1 + SPRINGS)) < tolerance


def test_streaming_is_batch_while_it_slips(
    slow: Model, lively: Array, streamed: Callable[[Model, Array, float], Array]
) -> None:
    model = slow.with_link(LINK, alpha=3e4, distributed=0.8, widest=1.5e-5)
    np.testing.assert_array_equal(streamed(model, lively, 1e-3), simulate(model, lively, 1e-3))


def test_a_planted_slip_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = np.array([8e6, 1.4e-5, -0.5])
    asked_for = {"alpha": truth[0], "widest": truth[1], "taper": truth[2]}
    rig = paper.with_link(LINK, distributed=1.0, **asked_for)
    start = {"alpha": 5e6, "widest": 1e-5, "taper": -1.4}
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.1 * np.abs(truth))


def test_it_says_how_far_it_remembers() -> None:
    says = link_named(LINK).says
    assert says is not None
    values = {"alpha": 2e6, "beta": 5e5, "gamma": -3e5, "n": 1.0, "widest": 1e-5}
    slipping = says(values | {"distributed": 1.0}, SCALES)
    assert slipping.endswith("4.0 % stiffer, until the finger has moved about 20 µm")
    bending = says(values | {"distributed": 0.0}, SCALES)
    assert bending.endswith("20 % stiffer, until the finger has moved about 15 µm")
    saturated = advance(0.0, 1e-3, 2e6, 5e5, -3e5, 1.0)
    just_back = advance(saturated, -1e-9, 2e6, 5e5, -3e5, 1.0)
    assert (saturated - just_back) / 1e-9 == pytest.approx(0.2 * SCALES.stiffness, rel=0.01)
    forgotten = advance(saturated, -15e-6, 2e6, 5e5, -3e5, 1.0)
    assert abs(forgotten + saturated) < 0.1 * 2.0 * saturated
    longer = says(values | {"distributed": 0.0, "gamma": -4e5}, SCALES)
    assert longer.endswith("up to 40 % stiffer, and remembers for more than a stroke")
    growing = says(values | {"distributed": 0.0, "gamma": -6e5}, SCALES)
    assert growing.endswith("it remembers where the finger has been")


@pytest.mark.parametrize("rest", [60.0, 10.0])
def test_a_recording_that_begins_on_the_way_back_goes_on_nearly_as_it_would(
    paper: Model, rest: float
) -> None:
    """From h alone, what came before is told but roughly; as if from 0 V, half would be left."""
    rig = paper.with_link(LINK, alpha=4e6, beta=1e6, gamma=2e5)
    before = np.concatenate([np.linspace(0.0, 140.0, 2000), np.linspace(140.0, rest, 1500)])
    after = rest + (150.0 - rest) * 0.5 * (1.0 - np.cos(2.0 * np.pi * np.arange(3000) * 1e-3))
    whole = simulate(rig, np.concatenate([before, after[1:]]), 1e-3)[len(before) - 1 :]
    h, values = 0.0, paper.values("bouc_wen")
    for change in np.diff(before):
        rates = values["beta"], values["gamma"], values["n"]
        h = advance(h, change, values["alpha"] * values["d"], *rates)

    def off(model: Model) -> float:
        begun = simulate(model, after, 1e-3, initial=Initial.FIRST_SAMPLE, initial_hysteresis=h)
        return float(np.std((begun - whole)[1:]))

    assert off(rig) < 0.3 * off(paper)


@pytest.mark.parametrize("n", [1.0, 2.0, 3.0])
def test_made_stronger_it_does_the_same_only_stronger(n: float) -> None:
    """Of a force that is ten times as large each power of z fades it by another power of ten."""
    weak = {"alpha": 1e6, "beta": 2e5 * 0.3 ** (1.0 - n), "gamma": -1e5 * 0.3 ** (1.0 - n), "n": n}
    strong = {**weak, "alpha": 10.0 * weak["alpha"], **rescaled(weak, 10.0)}
    places = np.array([0.0, 8e-6, 2e-6, 5e-6, 4e-6])
    np.testing.assert_allclose(asked(strong, places), 10.0 * asked(weak, places), rtol=1e-9)
    assert np.ptp(asked(weak, places)) > 0.1
