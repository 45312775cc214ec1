"""Play against its own definition, the geometry of its loops and a general integrator."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.signals import POSITION, Array
from microgripper_control.effects.base import Scales
from microgripper_control.effects.registry import link_named
from microgripper_control.effects.transmission.backlash import PINS
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

PLAY = 2e-6  # m
STEPS = (0.3e-3, 0.7e-3)  # s
LAGS = (2e-5, 4e-4, 5e-3)  # s, T: from far shorter than a step to far longer
Alone = Callable[..., Array]


@pytest.fixture
def wander() -> Array:
    """Motion from rest, m, the ends of 200 periods of STEPS."""
    return np.append(0.0, np.random.default_rng(5).normal(scale=0.6e-6, size=399).cumsum())


def trailed(alone: Alone, x: Array, lag: float, play: float = PLAY) -> Array:
    values = {"play": play, "slowness": lag / play}
    return alone("backlash", values, x, STEPS, row=POSITION, ramped=True)


def integrated(x: Array, lag: float) -> Array:
    """The definition by a general integrator, in steps too short for it to miss a flank."""

    def rates(t: float, y: Array, old: float, rate: float) -> Array:
        e = old + rate * t - y
        return (e - np.clip(e, -0.5, 0.5)) / lag

    y, finger, scaled = np.zeros(1), [], np.append(0.0, x / PLAY)
    options = {"max_step": 1e-4, "rtol": 1e-9, "atol": 1e-11}
    for j, (old, new) in enumerate(pairwise(scaled)):
        end = STEPS[j % 2]
        best = solve_ivp(rates, (0.0, end), y, "DOP853", args=(old, (new - old) / end), **options)
        y = best.y[:, -1]
        finger.append(y[0])
    return PLAY * np.array(finger)


def played(alone: Alone, x: Array) -> Array:
    values = {"play": PLAY, "slowness": 0.0}
    return alone("backlash", values, x, (1e-3,), row=POSITION, ramped=True)


def test_the_finger_rests_inside_the_gap_and_is_pushed_at_its_flanks(alone: Alone) -> None:
    x = 1e-6 * np.array([0.0, 0.9, -0.9, 3.0, 1.5, 1.0, 0.0, -1.0, 0.5, 1.0, 1.5])
    expected = 1e-6 * np.array([0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.5])
    np.testing.assert_allclose(played(alone, x), expected, atol=1e-20)


def test_a_cycle_is_a_parallelogram(alone: Alone) -> None:
    """As wide as the play, and as high as the motion less the play."""
    x = 10e-6 * np.sin(np.linspace(0.0, 6.0 * np.pi, 6001))
    out = played(alone, x)[2000:]
    assert np.ptp(out) == pytest.approx(20e-6 - PLAY, rel=1e-6)
    motion = x[2000:]
    down, up = (  # where the finger passes the middle on its way
        np.interp(0.0, sign * out[part], motion[part])
        for sign, part in ((-1.0, slice(500, 1500)), (1.0, slice(1500, 2500)))
    )
    assert up - down == pytest.approx(PLAY, rel=1e-3)


def test_only_the_course_counts_not_its_speed(alone: Alone) -> None:
    """Sampled ten times as densely, or held where it is now and then, x moves the finger alike."""
    x = np.random.default_rng(1).normal(scale=2e-6, size=400)
    dense = np.interp(np.arange(0, 3991) / 10.0, np.arange(400), x)
    np.testing.assert_allclose(played(alone, dense)[::10], played(alone, x), atol=1e-19)
    np.testing.assert_array_equal(played(alone, np.repeat(x, 3))[::3], played(alone, x))


@pytest.mark.parametrize("slowness", [0.0, 2e3])
@pytest.mark.parametrize("rig", ["paper", "slow"])
def test_ringing_between_the_samples_pushes_the_finger(
    rig: str,
    slowness: float,
    request: pytest.FixtureRequest,
    lively: Array,
    finely: Callable[[Model, Array, float], Array],
) -> None:
    base: Model = request.getfixturevalue(rig)
    model = base.with_link("backlash", play=2e-7, slowness=slowness)
    expected = finely(model, lively, 1e-3)
    absent = simulate(base, lively, 1e-3)
    error = np.linalg.norm(simulate(model, lively, 1e-3) - expected)
    assert error < 0.02 * np.linalg.norm(absent - expected)


def test_it_never_moves_the_finger_by_more_than_half_the_play(alone: Alone) -> None:
    x = np.random.default_rng(2).normal(scale=3e-6, size=1000).cumsum()
    assert np.max(np.abs(played(alone, x) - x)) == pytest.approx(PLAY / 2.0, rel=1e-9)


def test_a_planted_play_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    rig = paper.with_link("backlash", play=3e-7)
    found, errors = recover(rig, "backlash", {"play": 2e-7}, lively, 1e-3)
    assert abs(found[0] - 3e-7) < 4.0 * errors[0]
    assert errors[0] < 3e-9


@pytest.mark.parametrize("lag", LAGS)
def test_a_trailing_finger_meets_an_integrator(alone: Alone, wander: Array, lag: float) -> None:
    x = wander[:80]
    found, expected = trailed(alone, x, lag), integrated(x, lag)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6 * PLAY)
    assert np.max(np.abs(found - played(alone, x))) > 0.03 * PLAY


@pytest.mark.parametrize("lag", LAGS)
def test_it_trails_a_ramp_by_half_the_play_and_what_the_lag_takes(alone: Alone, lag: float) -> None:
    rate = 3e-3  # m/s
    x = rate * np.cumsum(np.tile(STEPS, 100))
    expected = PLAY / 2.0 + rate * lag
    assert x[-1] - trailed(alone, x, lag)[-1] == pytest.approx(expected, rel=1e-7)


def test_it_comes_to_rest_at_the_flank(alone: Alone) -> None:
    """What is left to go dies away with T after x has stopped."""
    lag = 2e-3
    x = np.append(0.0, np.full(39, 3e-6))
    left = 3e-6 - PLAY / 2.0 - trailed(alone, x, lag)
    t = np.cumsum(np.tile(STEPS, 20))
    np.testing.assert_allclose(left[1:], left[1] * np.exp(-(t[1:] - t[1]) / lag), rtol=1e-9)


def test_without_lag_it_is_the_play_operator(alone: Alone, wander: Array) -> None:
    ideal = alone("backlash", {"play": PLAY, "slowness": 0.0}, wander, STEPS, row=POSITION)
    np.testing.assert_array_equal(ideal, played(alone, wander))
    errors = [np.max(np.abs(trailed(alone, wander, lag) - ideal)) for lag in (1e-7, 1e-9, 1e-30)]
    assert errors[0] < 1e-2 * PLAY
    assert errors[1] < 1.1e-2 * errors[0]
    assert errors[2] < 1e-9 * PLAY


def test_with_a_given_lag_and_no_play_it_would_be_a_lag(alone: Alone, wander: Array) -> None:
    lag, play = 2e-3, 1e-15
    values = {"averaging": 0.0, "time_constant": lag}
    expected = alone("sensor_lag", values, wander, STEPS, row=POSITION, ramped=True)
    np.testing.assert_allclose(trailed(alone, wander, lag, play), expected, rtol=0.0, atol=2 * play)


def test_the_lag_goes_with_the_play(paper: Model, lively: Array) -> None:
    absent = simulate(paper, lively, 1e-3)
    errors = []
    for play in (1e-8, 1e-10):
        model = paper.with_link("backlash", play=play, slowness=3e3)
        errors.append(np.max(np.abs(simulate(model, lively, 1e-3) - absent)))
    assert errors[1] < 0.02 * errors[0]


def test_streaming_is_batch_for_a_trailing_finger(
    slow: Model, lively: Array, streamed: Callable[[Model, Array, float], Array]
) -> None:
    model = slow.with_link("backlash", play=PLAY, slowness=3e3)
    batch = simulate(model, lively, 1e-3)
    np.testing.assert_array_equal(streamed(model, lively, 1e-3), batch)


@pytest.mark.parametrize("slowness", [0.0, 3e3])
@pytest.mark.parametrize(("h", "side"), [(1e-6, -1.0), (-1e-6, 1.0)])
def test_a_run_begins_at_the_flank_that_h_remembers(
    paper: Model, slowness: float, h: float, side: float
) -> None:
    """And there the finger rests: its way back begins with the whole gap."""
    model = paper.with_link("backlash", play=PLAY, slowness=slowness)
    for hold in Hold:
        options = {"hold": hold, "initial": Initial.FIRST_SAMPLE, "initial_hysteresis": h}
        bare = simulate(paper, np.full(50, 70.0), 1e-3, **options)
        moved = simulate(model, np.full(50, 70.0), 1e-3, **options)
        np.testing.assert_allclose(moved - bare, side * PLAY / 2.0, rtol=0.0, atol=1e-6 * PLAY)


def test_a_planted_lag_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = np.array([3e-7, 4e3])
    rig = paper.with_link("backlash", play=truth[0], slowness=truth[1])
    start = {"play": 2e-7, "slowness": 1e3}
    found, errors = recover(rig, "backlash", start, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.03 * truth)


def test_it_says_what_it_found() -> None:
    scales = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (0.0, 2e-5), 1e7, 0.0038)
    says = link_named("backlash").says
    assert says is not None
    assert says({"play": 2.1e-7, "spread": 0.0, "slowness": 0.0}, scales).endswith("finger: 210 nm")
    slow = {"play": 2e-7, "spread": 0.6, "slowness": 1e4}
    assert "200 nm, taken up over 60 % of it" in says(slow, scales)
    assert says(slow, scales).endswith("a time constant of 2.0 ms")
    worn = {"play": 2e-7, "spread": 1.0, "slowness": 0.0}
    assert says(worn, scales).endswith("200 nm, taken up bit by bit")


@pytest.mark.parametrize("slowness", [0.0, 2e3])
def test_a_gap_that_is_taken_up_bit_by_bit_is_many_gaps(
    alone: Alone, wander: Array, slowness: float
) -> None:
    spread = 0.7
    values = {"play": PLAY, "spread": spread, "slowness": slowness}
    found = alone("backlash", values, wander, STEPS, row=POSITION, ramped=True)
    gaps = PLAY * (1.0 - spread * np.arange(PINS) / (PINS - 1))
    each = [trailed(alone, wander, slowness * PLAY, gap) for gap in gaps]
    np.testing.assert_allclose(found, np.mean(each, axis=0), atol=1e-12 * PLAY)


def test_after_a_turn_it_follows_the_more_the_further_it_has_gone(alone: Alone) -> None:
    """At rest within the narrowest gap, as x itself beyond the widest."""
    x = np.append(np.linspace(0.0, 5e-6, 500), np.linspace(5e-6, 0.0, 5001))
    values = {"play": PLAY, "spread": 0.5, "slowness": 0.0}
    out = alone("backlash", values, x, (1e-3,), row=POSITION, ramped=True)
    slope = np.diff(out[500:]) / np.diff(x[500:])
    back = (5e-6 - x[500:])[1:]
    np.testing.assert_allclose(slope[back < 0.49 * PLAY], 0.0, atol=1e-9)
    np.testing.assert_allclose(slope[back > 1.01 * PLAY], 1.0, rtol=1e-6)
    assert np.all(np.diff(slope) > -1e-6)


def test_a_planted_spread_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = {"play": 3e-7, "spread": 0.6}
    rig = paper.with_link("backlash", **truth)
    found, errors = recover(rig, "backlash", {"play": 2e-7, "spread": 0.3}, lively, 1e-3)
    assert np.all(np.abs(found - list(truth.values())) < 4.0 * errors)
    assert np.all(errors < 0.1 * np.array(list(truth.values())))
