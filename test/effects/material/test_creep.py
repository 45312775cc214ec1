"""Creep against its closed forms, an integrator and the logarithm it stands for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import FREE, Array
from microgripper_control.effects.base import Scales
from microgripper_control.effects.material.creep import LINK, courses, time_constants
from microgripper_control.effects.registry import link_named
from microgripper_control.identification.fit import fit
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

Alone = Callable[..., Array]
VALUES = {"strength": 0.02, "fastest": 0.01, "slowest": 1000.0}


def step_response(values: dict[str, float], time: Array) -> Array:
    taus = time_constants(values)
    share = values["strength"] * abs(np.log10(values["slowest"] / values["fastest"])) / len(taus)
    grown: Array = 1.0 + share * np.sum(-np.expm1(-time[:, None] / taus), axis=1)
    return grown


def test_a_held_step_is_followed_exactly(alone: Alone) -> None:
    steps = (0.2e-3, 0.5e-3, 0.3e-3)
    out = alone("creep", VALUES, np.ones(9000), steps, row=FREE)
    np.testing.assert_allclose(
        out, step_response(VALUES, np.cumsum(np.resize(steps, 9000))), rtol=1e-12
    )


@pytest.mark.parametrize("ramped", [False, True])
def test_any_input_is_followed_exactly(alone: Alone, ramped: bool) -> None:
    values = {"strength": 0.3, "fastest": 5e-3, "slowest": 2.0}
    signal, step = np.random.default_rng(0).normal(size=30).cumsum(), 4e-3
    taus = time_constants(values)
    share = 0.3 * np.log10(values["slowest"] / values["fastest"]) / len(taus)
    y, old, expected = np.zeros(len(taus)), 0.0, []
    for new in signal:

        def rates(t: float, y: Array, old: float = old, new: float = new) -> Array:
            w = old + (new - old) * t / step if ramped else new
            return (w - y) / taus

        y = solve_ivp(rates, (0.0, step), y, "DOP853", rtol=1e-11, atol=1e-14).y[:, -1]
        expected.append(new + share * y.sum())
        old = new
    out = alone("creep", values, signal, (step,), row=FREE, ramped=ramped)
    np.testing.assert_allclose(out, expected, rtol=1e-9)


ACTIVATED = {"strength": 0.1, "fastest": 0.5, "slowest": 5.0, "activation": 2e6}


def activated_exactly(signal: Array, step: float, ramped: bool) -> Array:
    """What ACTIVATED makes of a free displacement in um, by an integrator, um."""
    taus, activation = time_constants(ACTIVATED), 1e-6 * ACTIVATED["activation"]
    s, old, expected = np.zeros(len(taus)), 0.0, []
    for new in signal:

        def rates(t: float, s: Array, old: float = old, new: float = new) -> Array:
            w = old + (new - old) * t / step if ramped else new
            rate: Array = np.sinh(activation * (w - s)) / (activation * taus)
            return rate

        s = solve_ivp(rates, (0.0, step), s, "Radau", rtol=1e-9, atol=1e-12).y[:, -1]
        expected.append(new + 0.1 / len(taus) * s.sum())
        old = new
    return np.array(expected)


def test_activated_elements_follow_held_input_exactly(alone: Alone) -> None:
    signal, step = np.random.default_rng(0).normal(size=30).cumsum(), 0.05
    found = alone("creep", ACTIVATED, 1e-6 * signal, (step,), row=FREE)
    expected = activated_exactly(signal, step, ramped=False)
    assert np.std(expected - signal) > 0.02
    np.testing.assert_allclose(1e6 * found, expected, rtol=0.0, atol=1e-7)


def test_activated_elements_follow_a_smooth_course_nearly(alone: Alone) -> None:
    step = 5e-3
    signal = 8.0 * (1.0 - np.cos(2.0 * np.pi * step * np.arange(300)))
    found = alone("creep", ACTIVATED, 1e-6 * signal, (step,), row=FREE, ramped=True)
    expected = activated_exactly(signal, step, ramped=True)
    crept = expected - signal
    np.testing.assert_allclose(1e6 * found, expected, rtol=0.0, atol=5e-3 * np.ptp(crept))


def test_activated_it_goes_on_by_the_same_length_in_a_decade_whatever_the_step(
    alone: Alone,
) -> None:
    """With tanh(late / 2) = exp(-t / tau) that is ln(10) / activation, times the share."""
    values = {"strength": 0.1, "fastest": 1e3, "slowest": 1e4, "activation": 2e6}
    for step in (6e-6, 12e-6):
        crept = alone("creep", values, np.full(10_000, step), (0.1,), row=FREE) - step
        decade = crept[9_990] - crept[999 - 1]
        assert decade == pytest.approx(0.1 * np.log(10.0) / 2e6, rel=0.15)


def test_hardly_activated_it_is_the_row_of_elements(paper: Model, lively: Array) -> None:
    plain, hardly = (
        simulate(paper.with_link("creep", strength=0.05, activation=activation), lively, 1e-3)
        for activation in (0.0, 1.0)
    )
    without = simulate(paper, lively, 1e-3)
    np.testing.assert_allclose(hardly, plain, rtol=0.0, atol=1e-3 * np.ptp(plain - without))


def test_the_less_it_is_activated_the_nearer_it_comes_to_them(paper: Model) -> None:
    step = np.append(0.0, np.full(2000, 80.0))
    plain = simulate(paper.with_link("creep"), step, 1e-3)
    for activation in (1.0, 1e-3, 1e-6, 1e-9):
        hardly = simulate(paper.with_link("creep", activation=activation), step, 1e-3)
        np.testing.assert_allclose(hardly, plain, rtol=0.0, atol=1e-10 * activation + 1e-15)


def test_each_decade_adds_the_same_share() -> None:
    time = np.logspace(-1.0, 1.0, 201)  # well inside the range of the time constants
    grown = step_response(VALUES, time)
    per_decade = np.gradient(grown, np.log10(time))
    np.testing.assert_allclose(per_decade, VALUES["strength"], rtol=0.02)


def test_a_narrow_range_is_one_time_constant() -> None:
    values = {"strength": 10.0, "fastest": 1.0, "slowest": 1.01}
    time = np.linspace(0.0, 5.0, 50)
    total = 10.0 * np.log10(1.01)
    expected = 1.0 + total * -np.expm1(-time / np.sqrt(1.01))
    np.testing.assert_allclose(step_response(values, time), expected, rtol=1e-5)


def test_the_order_of_the_two_time_constants_is_free(paper: Model, lively: Array) -> None:
    there = paper.with_link("creep", strength=0.02, fastest=0.1, slowest=10.0)
    back = paper.with_link("creep", strength=0.02, fastest=10.0, slowest=0.1)
    a, b = simulate(there, lively, 1e-3), simulate(back, lively, 1e-3)
    np.testing.assert_allclose(a, b, rtol=1e-12)


def test_its_courses_are_what_an_unfinished_past_leaves(paper: Model) -> None:
    """A record that begins within a long run, against the same run begun at rest there."""
    rng = np.random.default_rng(2)
    model = paper.with_link("creep", **{**VALUES, "slowest": 20.0})
    model = model.with_values({("bouc_wen", "alpha"): 0.0})
    u = np.repeat(rng.uniform(0.0, 160.0, 40), 100)
    whole = simulate(model, u, 1e-3)[2000:]
    part = simulate(model, u[1999:], 1e-3, initial=Initial.FIRST_SAMPLE)[1:]
    shapes = courses(model.values("creep"), 1e-3 * np.arange(len(whole)))
    missing = whole - part
    weights, *_ = np.linalg.lstsq(shapes.T, missing, rcond=None)
    assert np.max(np.abs(missing)) > 1e-8
    np.testing.assert_allclose(weights @ shapes, missing, rtol=0.0, atol=1e-13)


def test_it_stands_behind_the_hysteresis_and_before_the_mechanics() -> None:
    assert link_named("bouc_wen").place < link_named("creep").place
    assert link_named("creep").place < link_named("second_order").place


def holds(seconds: float, period: float) -> Array:
    """Steps to random voltages, held for 0.1 to 10 s, V."""
    rng = np.random.default_rng(11)
    parts: list[Array] = []
    while sum(map(len, parts)) * period < seconds:
        parts.append(np.full(int(10.0 ** rng.uniform(-1.0, 1.0) / period), rng.uniform(0.0, 160.0)))
    return np.concatenate(parts)[: int(seconds / period)]


def test_planted_values_are_found(
    paper: Model, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = np.array([0.013, 0.03])
    rig = paper.with_link("creep", strength=truth[0], fastest=truth[1])
    start = {"strength": 0.005, "fastest": 0.01}
    found, errors = recover(rig, "creep", start, holds(60.0, 5e-3), 5e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert errors[0] < 0.02 * truth[0]
    assert errors[1] < 0.2 * truth[1]


def test_identification_finds_it_beside_the_rest(paper: Model) -> None:
    truth = paper.with_link("creep", strength=0.013, fastest=0.03)
    u = holds(20.0, 2e-2)
    noise = 15e-9 * np.random.default_rng(1).normal(size=len(u))
    record = Recording("run", 2e-2, u, simulate(truth, u, 2e-2) + noise)
    found = fit(paper.with_link("creep"), [record])
    assert found.rmse[0] == pytest.approx(15e-9, rel=0.05)
    interval = found.model.settings["creep"]["strength"].interval
    assert interval is not None
    assert interval[0] < 0.013 < interval[1]
    assert found.model.value("bouc_wen", "d") == pytest.approx(1.4447e-7, rel=0.01)


def test_a_periodic_voltage_meets_its_cycle_at_once(paper: Model) -> None:
    """Slow creep would take hours of cycles; the many cycles here are of the faster kind."""
    u = 80.0 + 60.0 * np.sin(np.arange(400) / 400.0 * 2.0 * np.pi)
    model = paper.with_link("creep", strength=0.05, fastest=0.01, slowest=0.3)
    at_once = simulate(model, u, 2.5e-3, hold=Hold.ZERO, initial=Initial.PERIODIC)
    waited = simulate(model, np.tile(u, 30), 2.5e-3)[-400:]
    np.testing.assert_allclose(at_once, waited, rtol=0.0, atol=1e-7 * np.ptp(waited))


@pytest.mark.parametrize(("size", "expected"), [(0.5, True), (50.0, False)])
def test_creep_from_before_a_recording_is_no_larger_than_creep(size: float, expected: bool) -> None:
    """Two decades at 1 % are 0.4 um of a stroke of 20 um; ten times as much is a drift."""
    values = {"strength": 0.01, "fastest": 0.1, "slowest": 10.0}
    scales = Scales(1e-3, 44.0, (0.0, 160.0), 500.0, (0.0, 20e-6), 5e7, 0.0038)
    course = size * 0.4e-6 * np.exp(-np.linspace(0.0, 6.0, 500))
    assert LINK.credible(values, course, scales) == expected
