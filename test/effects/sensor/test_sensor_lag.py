"""Averaging and filter against integrals of the lines that they are given, and linear theory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from microgripper_control.core.signals import POSITION, Array
from microgripper_control.diagnosis.fits.trial import fitted_keys
from microgripper_control.effects.base import Scales
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

STEPS = (0.1e-3, 0.35e-3, 0.05e-3, 0.5e-3)  # s
Alone = Callable[..., Array]


def mean_before(t: Array, x: Array, averaging: float, at: float) -> float:
    """Mean of the line through (t, x), level before its first point, over a time up to `at`."""
    corners = np.unique(np.clip(np.append(t, [at - averaging, at]), at - averaging, at))
    return float(np.trapezoid(np.interp(corners, t, x), corners)) / averaging


@pytest.mark.parametrize("averaging", [1e-9, 0.07e-3, 0.5e-3, 1e-3, 2.3e-3, 4.0e-3, 50e-3])
def test_the_average_is_that_of_straight_lines(alone: Alone, averaging: float) -> None:
    x = np.random.default_rng(6).normal(size=200)
    values = {"averaging": averaging, "time_constant": 0.0}
    out = alone("sensor_lag", values, x, STEPS, row=POSITION, ramped=True, level=0.3)
    t = np.append(0.0, np.cumsum(np.resize(STEPS, 200)))
    line = np.append(0.3, x)
    expected = [mean_before(t, line, averaging, at) for at in t[1:]]
    np.testing.assert_allclose(out, expected, rtol=0.0, atol=1e-6 if averaging < 1e-8 else 1e-12)


def test_the_filter_is_exact_behind_straight_lines(alone: Alone) -> None:
    x = np.random.default_rng(7).normal(size=200)
    x[0] = 0.0
    values = {"averaging": 0.0, "time_constant": 1.7e-3}
    out = alone("sensor_lag", values, x, (1e-3,), row=POSITION, ramped=True)
    numerator, denominator, _ = cont2discrete(([1.0], [1.7e-3, 1.0]), 1e-3, "foh")
    np.testing.assert_allclose(out, lfilter(numerator[0], denominator, x), atol=1e-12)


@pytest.mark.parametrize("curvature", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("filtering", [0.2e-3, 1.7e-3])
def test_a_filter_of_second_order_is_exact_behind_straight_lines(
    alone: Alone, filtering: float, curvature: float
) -> None:
    x = np.random.default_rng(7).normal(size=200)
    x[0] = 0.0
    values = {"averaging": 0.0, "time_constant": filtering, "curvature": curvature}
    out = alone("sensor_lag", values, x, (1e-3,), row=POSITION, ramped=True)
    system = ([1.0], [curvature * filtering**2, filtering, 1.0])
    numerator, denominator, _ = cont2discrete(system, 1e-3, "foh")
    expected = lfilter(numerator[0], denominator, x)
    np.testing.assert_allclose(out, expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("curvature", [0.0, 0.5])
def test_the_filter_is_the_same_on_unequal_steps(alone: Alone, curvature: float) -> None:
    """With a corner of the line at each sample and steps that divide the way between."""
    x = np.random.default_rng(9).normal(size=100)
    ends = np.cumsum(STEPS) / sum(STEPS)
    divided = np.append(0.0, x)[:-1, None] + np.diff(x, prepend=0.0)[:, None] * ends
    values = {"averaging": 0.0, "time_constant": 1.7e-3, "curvature": curvature}
    whole = alone("sensor_lag", values, x, (sum(STEPS),), row=POSITION, ramped=True)
    out = alone("sensor_lag", values, divided.ravel(), STEPS, row=POSITION, ramped=True)
    np.testing.assert_allclose(out[len(STEPS) - 1 :: len(STEPS)], whole, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("curvature", [0.0, 0.5])
def test_no_time_constant_is_no_filter(alone: Alone, curvature: float) -> None:
    x = np.random.default_rng(10).normal(size=100)
    for filtering in (0.0, 1e-200):
        values = {"averaging": 0.0, "time_constant": filtering, "curvature": curvature}
        out = alone("sensor_lag", values, x, STEPS, row=POSITION, ramped=True)
        np.testing.assert_array_equal(out, x)
    values = {"averaging": 0.0, "time_constant": 1e-15, "curvature": curvature}
    out = alone("sensor_lag", values, x, STEPS, row=POSITION, ramped=True)
    np.testing.assert_allclose(out, x, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("curvature", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(("averaging", "filtering"), [(4e-3, 0.0), (0.0, 3e-3), (2.7e-3, 1e-3)])
def test_it_is_late_by_both_times(
    alone: Alone, averaging: float, filtering: float, curvature: float
) -> None:
    """Behind a ramp by half of the one and all of the other."""
    t = np.cumsum(np.resize(STEPS, 600))
    values = {"averaging": averaging, "time_constant": filtering, "curvature": curvature}
    out = alone("sensor_lag", values, 2.0 * t, STEPS, row=POSITION, ramped=True)
    late = averaging / 2.0 + filtering
    np.testing.assert_allclose(out[400:], 2.0 * (t[400:] - late), rtol=1e-6)


@pytest.mark.parametrize("curvature", [0.0, 0.5, 1.0])
def test_a_level_stays_for_ever(alone: Alone, curvature: float) -> None:
    values = {"averaging": 2.3e-3, "time_constant": 1e-3, "curvature": curvature}
    level = 1.7e-5
    x = np.full(1_000_000, level)
    out = alone("sensor_lag", values, x, STEPS, row=POSITION, ramped=True, level=level)
    np.testing.assert_allclose(out, level, rtol=1e-11)


@pytest.mark.parametrize("rig", ["paper", "slow"])
@pytest.mark.parametrize("filtering", [1e-4, 1e-3, 5e-3])
def test_behind_the_mechanics_the_filter_meets_theory(
    rig: str,
    request: pytest.FixtureRequest,
    without_hysteresis: Callable[[Model], Model],
    filtered: Callable[..., Array],
    lively: Array,
    filtering: float,
) -> None:
    linear = without_hysteresis(request.getfixturevalue(rig))
    expected = filtered(linear, lively, ([1.0], [filtering, 1.0]))
    model = linear.with_link("sensor_lag", averaging=0.0, time_constant=filtering)
    error = np.linalg.norm(simulate(model, lively, 1e-3) - expected)
    # What matters is how late the reading is: compare with one late by 3 us.
    model = linear.with_link("sensor_lag", averaging=0.0, time_constant=filtering + 3e-6)
    assert error < np.linalg.norm(simulate(model, lively, 1e-3) - expected)


@pytest.mark.parametrize("rig", ["paper", "slow"])
@pytest.mark.parametrize("filtering", [1e-4, 1e-3, 5e-3])
@pytest.mark.parametrize("curvature", [0.25, 0.5, 1.0])
def test_behind_the_mechanics_a_filter_of_second_order_meets_theory(
    rig: str,
    request: pytest.FixtureRequest,
    without_hysteresis: Callable[[Model], Model],
    filtered: Callable[..., Array],
    lively: Array,
    filtering: float,
    curvature: float,
) -> None:
    linear = without_hysteresis(request.getfixturevalue(rig))
    low_pass = [curvature * filtering**2, filtering, 1.0]
    expected = filtered(linear, lively, ([1.0], low_pass))
    values = {"averaging": 0.0, "time_constant": filtering, "curvature": curvature}
    found, absent = (
        simulate(model, lively, 1e-3)
        for model in (linear.with_link("sensor_lag", **values), linear)
    )
    # A short one is over before the next sample of a stiff rig: there is nothing to compare with.
    unseen = 1e-9 * np.sqrt(len(lively))
    share = 0.04 if filtering < 1e-3 else 0.002
    error = np.linalg.norm(found - expected)
    assert error < share * np.linalg.norm(absent - expected) + unseen


@pytest.mark.parametrize("rig", ["paper", "slow"])
def test_behind_the_mechanics_the_average_is_that_of_the_motion(
    rig: str, request: pytest.FixtureRequest, lively: Array
) -> None:
    """The same rig sampled 200 times as fast gives the motion to be averaged."""
    base: Model = request.getfixturevalue(rig)
    dense = simulate(base, np.repeat(lively, 200), 5e-6)
    area = np.append(0.0, np.cumsum((dense[1:] + dense[:-1]) / 2.0))
    window = 460  # of 5 us
    expected = (area - np.append(np.zeros(window), area)[: len(area)])[::200] / window
    model = base.with_link("sensor_lag", averaging=2.3e-3, time_constant=0.0)
    found, absent = (simulate(m, lively, 1e-3) for m in (model, base))
    assert np.linalg.norm(found - expected) < 0.01 * np.linalg.norm(absent - expected)


def test_planted_times_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    rig = paper.with_link("sensor_lag", averaging=2.6e-3, time_constant=0.4e-3)
    start = {"averaging": 1.5e-3, "time_constant": 1e-3}
    found, errors = recover(rig, "sensor_lag", start, lively, 1e-3)
    assert np.all(np.abs(found - [2.6e-3, 0.4e-3]) < 4.0 * errors)
    assert np.all(errors < 5e-6)


@pytest.mark.parametrize("truth", [(0.0, 1.5e-3, 0.5), (1.3e-3, 0.9e-3, 0.3)])
def test_a_planted_filter_of_second_order_is_found(
    paper: Model,
    lively: Array,
    recover: Callable[..., tuple[Array, Array]],
    truth: tuple[float, float, float],
) -> None:
    planted = dict(zip(("averaging", "time_constant", "curvature"), truth, strict=True))
    start = {"averaging": 0.5e-3, "time_constant": 2e-3, "curvature": 0.5}
    if not truth[0]:  # at a bound there is no error to speak of
        start.pop("averaging")
    found, errors = recover(
        paper.with_link("sensor_lag", **planted), "sensor_lag", start, lively, 1e-3
    )
    assert np.all(np.abs(found - [planted[name] for name in start]) < 4.0 * errors)
    assert errors[-2] < 0.01 * planted["time_constant"]
    assert errors[-1] < 0.02


def test_only_a_start_of_second_order_is_fitted_as_one(paper: Model) -> None:
    link = registry()["sensor_lag"]
    scales = Scales(1e-3, 10.0, (0.0, 150.0), 1e4, (0.0, 20e-6), 5e7, 0.0038)
    models = [paper.with_link("sensor_lag", **values) for values in link.starts(scales)]
    fitted = [fitted_keys(model, ["sensor_lag"]) for model in models]
    of_second = [model.value("sensor_lag", "curvature") > 0.0 for model in models]
    assert of_second.count(True) == 5
    assert [len(keys) for keys in fitted] == [3 if second else 2 for second in of_second]
