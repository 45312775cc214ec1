"""The loop that widens with the rate: its average of it, the logarithm, slow and fast limits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.signals import (
    FREE,
    HYSTERESIS,
    LEVELS,
    ROWS,
    VOLTAGE,
    Array,
    Timing,
)
from microgripper_control.effects.base import Scales
from microgripper_control.effects.registry import link_named
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

LINK = "rate_dependent_hysteresis"
VALUES = {"strength": 0.2, "memory": 0.03, "reference": 5.0}
PLAIN = {"fading": 0.0, "turning": 0.0, "power": 0.0, "late": 0.0, "slope": 0.0}
PLAYS = {"strength": 0.0, "slope": 3e-8, "widest": 24.0, "growth": 0.3}
SCALED = VALUES | PLAIN | {"beta": 0.0152, "gamma": -0.0227, "fed": 0.0, "pivot": 0.0}
SCALED |= {"widest": 1.0, "growth": 0.0}


def added(u: Array, h: Array, steps: tuple[float, ...], ramped: bool, **changed: float) -> Array:
    """What the link adds to the free displacement for given u and h."""
    link = link_named(LINK)
    prepared = link.prepare(SCALED | changed, Timing(sum(steps), steps, ramped), np.zeros(LEVELS))
    bus = np.zeros((ROWS, len(u)))
    bus[VOLTAGE], bus[HYSTERESIS] = u, h
    link.kernel(prepared.coefficients, prepared.state, bus)
    return bus[FREE]


def share(rate: Array) -> Array:
    return VALUES["strength"] * np.log10(1.0 + rate / VALUES["reference"])


def test_at_a_steady_rate_it_is_the_logarithm_of_it() -> None:
    for rate in (0.5, 50.0, 5000.0):
        u = rate * 1e-3 * np.arange(1, 1001)
        out = added(u, np.ones(1000), (1e-3,), True)
        np.testing.assert_allclose(out[-1], -share(np.array(rate)), rtol=1e-6)


@pytest.mark.parametrize("power", [-0.5, 1e-7, 0.4])
def test_with_a_power_the_decades_count_unequally(power: float) -> None:
    for rate in (0.5, 50.0, 5000.0):
        u = rate * 1e-3 * np.arange(1, 1001)
        out = added(u, np.ones(1000), (1e-3,), True, power=power, pivot=20.0)
        q = (VALUES["reference"] + rate) / (VALUES["reference"] + 20.0)
        grown = np.log10(q) if abs(power) < 1e-6 else (q**power - 1.0) / power / np.log(10.0)
        np.testing.assert_allclose(out[-1], -VALUES["strength"] * grown, rtol=2e-6)


def test_a_late_share_of_h_follows_within_the_memory() -> None:
    """After a jump of h the share is missing and comes as 1 - exp(-t / memory)."""
    steps, late = (0.4e-3, 0.6e-3), 0.3
    t = np.cumsum(np.resize(steps, 200))
    out = added(np.zeros(200), np.ones(200), steps, False, strength=0.0, late=late)
    np.testing.assert_allclose(out, late * np.exp(-t / VALUES["memory"]), rtol=1e-10)


def test_the_rate_is_averaged_over_the_memory() -> None:
    u = np.random.default_rng(0).normal(size=40).cumsum()
    step, rate, expected = 5e-3, 0.0, []
    for way in np.abs(np.diff(u, prepend=0.0)):

        def rates(t: float, r: Array, way: float = float(way)) -> Array:
            return (way / step - r) / VALUES["memory"]

        rate = solve_ivp(rates, (0.0, step), [rate], rtol=1e-10, atol=1e-12).y[0, -1]
        expected.append(rate)
    out = added(u, np.ones(40), (step,), True)
    np.testing.assert_allclose(out, -share(np.array(expected)), rtol=1e-7)


def test_a_jump_counts_as_its_height_spread_over_the_memory() -> None:
    t = np.cumsum(np.resize((0.4e-3, 0.6e-3), 200))
    out = added(np.full(200, 7.0), np.ones(200), (0.4e-3, 0.6e-3), False)
    rate = 7.0 / VALUES["memory"] * np.exp(-t / VALUES["memory"])
    np.testing.assert_allclose(out, -share(rate), rtol=1e-10)


def test_a_slow_cycle_is_the_paper_s(paper: Model) -> None:
    u = 80.0 - 80.0 * np.cos(np.arange(400) / 400.0 * 4.0 * np.pi)
    model = paper.with_link(LINK, **VALUES)
    x, absent = (simulate(m, u, 100.0, hold=Hold.FIRST) for m in (model, paper))
    assert np.max(np.abs(x - absent)) < 0.01 * 0.043 * np.ptp(absent)


def test_loops_widen_by_the_same_in_each_decade_of_rate(paper: Model) -> None:
    """Far above the reference, and with a memory long enough to scale the loop as a whole."""
    u = 80.0 - 80.0 * np.cos(np.arange(1000) / 1000.0 * 2.0 * np.pi)
    stiff = paper.with_values({("second_order", "m"): 1e-9, ("second_order", "b"): 1e-3})
    model = stiff.with_link(LINK, strength=0.2, memory=100.0, reference=1e-3)

    def width(model: Model, cycle: float) -> float:
        x = simulate(model, u, cycle / 1000.0, hold=Hold.FIRST, initial=Initial.PERIODIC)
        return float(np.max(x[501:] - x[499:0:-1]))

    widths = [width(model, cycle) for cycle in (10.0, 1.0, 0.1, 0.01)]
    np.testing.assert_allclose(np.diff(widths), 0.2 * width(stiff, 10.0), rtol=0.03)


def second(paper: Model, u: Array, period: float) -> Array:
    """A second Bouc-Wen variable that is fed f times as much as h, for a ramped voltage, m."""
    d, alpha, beta, gamma = (paper.value("bouc_wen", n) for n in ("d", "alpha", "beta", "gamma"))
    state, found = np.zeros(2), []
    for du in np.diff(u, prepend=0.0):
        slope = du / period

        def change(t: float, y: Array, slope: float = float(slope)) -> list[float]:
            feed = alpha * d * slope
            f = share(np.array(y[1]))
            decay = beta * abs(slope) * y[0] + gamma * slope * abs(y[0])
            return [f * feed - decay, (abs(slope) - y[1]) / VALUES["memory"]]

        state = solve_ivp(change, (0.0, period), state, rtol=1e-9, atol=1e-14).y[:, -1]
        found.append(state[0])
    return np.array(found)


def test_fed_it_is_a_second_bouc_wen_variable(paper: Model) -> None:
    """With the beta and gamma of h, on a voltage whose rate changes from cycle to cycle."""
    period = 1e-3
    t = period * np.arange(1500)
    u = 60.0 * np.sin(2.0 * np.pi * (1.0 + 3.0 * t) * t)
    model = paper.with_link(LINK, **VALUES, fed=1.0, beta=0.0152, gamma=-0.0227)
    x, plain = (
        simulate(m, u, period, hold=Hold.FIRST, initial=Initial.REST) for m in (model, paper)
    )
    gain = 5e7 / (5e7 + 8.2e5)
    expected = -gain * second(paper, u, period)
    np.testing.assert_allclose(x - plain, expected, rtol=0.0, atol=0.01 * np.ptp(expected))


def test_beta_and_gamma_may_follow_the_rate(paper: Model) -> None:
    """h + e is then a Bouc-Wen variable whose beta and gamma do, where it has the sign of h."""
    period, own = 1e-3, {"fading": 1e-3, "turning": -8e-4}
    t = period * np.arange(1500)
    u = 60.0 * np.sin(2.0 * np.pi * (1.0 + 3.0 * t) * t)
    model = paper.with_link(LINK, **VALUES | own | {"strength": 0.0}, beta=0.0152, gamma=-0.0227)
    x = simulate(model, u, period, hold=Hold.FIRST, initial=Initial.REST)
    d, alpha, beta, gamma = (paper.value("bouc_wen", n) for n in ("d", "alpha", "beta", "gamma"))
    state, expected = np.zeros(2), []
    for du in np.diff(u, prepend=0.0):

        def change(t: float, y: Array, slope: float = float(du / period)) -> list[float]:
            decades = np.log10(1.0 + y[1] / VALUES["reference"])
            decay = (beta + decades * own["fading"]) * abs(slope) * y[0]
            decay += (gamma + decades * own["turning"]) * slope * abs(y[0])
            return [alpha * d * slope - decay, (abs(slope) - y[1]) / VALUES["memory"]]

        state = solve_ivp(change, (0.0, period), state, rtol=1e-9, atol=1e-14).y[:, -1]
        expected.append(state[0])
    found = d * u - x * (5e7 + 8.2e5) / 5e7
    plain = d * u - simulate(paper, u, period, hold=Hold.FIRST) * (5e7 + 8.2e5) / 5e7
    changed = np.array(expected) - plain
    np.testing.assert_allclose(found - plain, changed, rtol=0.0, atol=0.05 * np.ptp(changed))


def test_fed_it_stays_where_the_voltage_rests() -> None:
    """What was added at the rate of a jump remains; scaled at once, it goes with the rate."""
    u = np.append(np.zeros(5), np.full(200, 7.0))
    h = 0.1 * u
    fed, scaled = (added(u, h, (1e-3,), False, fed=way) for way in (1.0, 0.0))
    jump = 0.7 * share(np.array(7.0 / VALUES["memory"]))
    np.testing.assert_allclose(fed[5:], -jump, rtol=1e-12)
    assert abs(scaled[-1]) < 0.1 * jump


@pytest.mark.parametrize("fed", [0.0, 1.0])
def test_at_the_pivot_the_loop_is_the_paper_s(fed: float) -> None:
    u = 50.0 * 1e-3 * np.arange(1, 1001)
    out = added(u, np.ones(1000), (1e-3,), True, pivot=50.0, fed=fed, beta=1.0, gamma=0.0)
    np.testing.assert_allclose(out[-1], 0.0, atol=1e-9)


@pytest.mark.parametrize("fed", [0.0, 0.4, 1.0])
def test_with_a_pivot_a_rig_at_rest_stays_at_rest(paper: Model, fed: float) -> None:
    model = paper.with_link("rate_dependent_hysteresis", fed=fed, pivot=1000.0).with_link("creep")
    found = simulate(
        model,
        np.full(200, 80.0),
        1e-3,
        initial=Initial.FIRST_SAMPLE,
        initial_hysteresis=1e-6,
    )
    assert np.ptp(found) < 1e-13


def test_how_the_samples_are_called_does_not_matter() -> None:
    link = link_named(LINK)
    u = np.random.default_rng(4).normal(size=90).cumsum()
    values = SCALED | {"fed": 1.0, "pivot": 30.0}
    whole = np.zeros((ROWS, 90))
    whole[VOLTAGE], whole[HYSTERESIS] = u, np.sin(u)
    parts = whole.copy()
    prepared = link.prepare(values, Timing(1e-3, (1e-3,), False), np.zeros(LEVELS))
    link.kernel(prepared.coefficients, prepared.state.copy(), whole)
    for start in range(0, 90, 7):
        link.kernel(prepared.coefficients, prepared.state, parts[:, start : start + 7])
    np.testing.assert_array_equal(parts, whole)


def test_planted_values_of_a_fed_loop_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = {"strength": 0.15, "memory": 0.05, "beta": 0.02, "gamma": -0.028}
    rig = paper.with_link(LINK, **truth, fed=1.0, pivot=100.0)
    start = {"strength": 0.05, "memory": 0.02, "beta": 0.015, "gamma": -0.0225}
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    wanted = np.array(list(truth.values()))
    assert np.all(np.abs(found - wanted) < 4.0 * errors)
    assert np.all(errors < 0.2 * np.abs(wanted))


def test_planted_values_of_a_scaled_loop_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = np.array([0.15, 0.05])
    rig = paper.with_link(LINK, strength=truth[0], memory=truth[1], fed=0.0)
    found, errors = recover(rig, LINK, {"strength": 0.05, "memory": 0.02}, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.1 * truth)


@pytest.mark.parametrize("ramped", [True, False])
def test_plays_widen_by_the_same_in_each_decade_of_rate(ramped: bool) -> None:
    """On a long ramp each play is its threshold behind: on average 9/16 of the widest one."""
    for rate in (0.5, 50.0, 5000.0):
        u = rate * 1e-3 * np.arange(1, 400_001)
        out = added(u, np.zeros(len(u)), (1e-3,), ramped, **PLAYS)
        # Held, a jump finds all of its height in the rate, and at the end of the step less is left.
        seen = rate * (1.0 if ramped else 1e-3 / VALUES["memory"] / np.expm1(1e-3 / 0.03))
        wider = PLAYS["growth"] * np.log10(1.0 + seen / VALUES["reference"])
        behind = PLAYS["slope"] * PLAYS["widest"] * 9.0 / 16.0 * wider
        np.testing.assert_allclose(out[-1], -behind, rtol=1e-6)


def test_plays_meet_plays_marched_finely() -> None:
    """A decaying oscillation, each play by itself, the rate by `solve_ivp`."""
    t = np.linspace(0.0, 3.0, 60_001)
    u = 60.0 * np.exp(-0.7 * t) * np.sin(2.0 * np.pi * (1.0 + 1.5 * t) * t)
    speed = np.gradient(u, t)
    memory = VALUES["memory"]
    solved = solve_ivp(
        lambda at, r: (np.abs(np.interp(at, t, speed)) - r) / memory,
        (0.0, 3.0),
        [0.0],
        t_eval=t,
        rtol=1e-8,
        max_step=1e-3,
    )
    wider = PLAYS["growth"] * np.log10(1.0 + solved.y[0] / VALUES["reference"])
    wanted = np.zeros(len(t))
    for threshold in PLAYS["widest"] * np.arange(1, 9) / 8.0:
        for sign, limits in ((1.0, threshold * (1.0 + wider)), (-1.0, np.full(len(t), threshold))):
            y = 0.0
            for j, limit in enumerate(limits):
                y = min(max(y, u[j] - limit), u[j] + limit)
                wanted[j] -= sign * PLAYS["slope"] / 8.0 * (u[j] - y)
    out = added(u[1:], np.zeros(len(u) - 1), (t[1],), True, **PLAYS)
    np.testing.assert_allclose(out, wanted[1:], atol=2e-4 * np.ptp(wanted))


def test_planted_values_of_widening_plays_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = {"memory": 0.03, "slope": 3e-8, "widest": 24.0, "growth": 0.4}
    rig = paper.with_link(LINK, **truth, strength=0.0, reference=50.0)
    start = {"memory": 0.02, "slope": 2e-8, "widest": 20.0, "growth": 0.3}
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    wanted = np.array(list(truth.values()))
    assert np.all(np.abs(found - wanted) < 4.0 * errors)
    assert np.all(errors < 0.3 * np.abs(wanted))


def test_what_lasts_for_long_is_no_rate() -> None:
    """A rate averaged over half the recording would follow any drift."""
    for period, duration in ((1e-3, 44.0), (5e-3, 0.5), (1e-4, 4000.0)):
        scales = Scales(period, duration, (0.0, 100.0), 100.0, (0.0, 2e-5), 5e7, 0.0038)
        link = link_named("rate_dependent_hysteresis")
        least, most = link.plausible(scales)["memory"]
        assert least < 3.0 * period < most <= max(0.02 * duration, 20.0 * period)
        assert all(least <= start["memory"] <= most * 1.0000001 for start in link.starts(scales))
