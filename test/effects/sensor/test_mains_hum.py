"""Hum: a Fourier series live, and courses that leave phase and amplitude to the recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.optimize import least_squares

from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import link_named
from microgripper_control.identification.nuisance import blocks
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

SIZES = {"amplitude": 6e-8, "second": 2e-8, "third": 1e-8, "fifth": 0.7e-8}  # m
VALUES = {"frequency": 49.97, **SIZES, "phase": 0.9}
HARMONICS = (1, 2, 3, 5)
PERIOD = 1e-3  # s
NOISE = 15e-9  # m


def series(time: Array) -> Array:
    angle = 2.0 * np.pi * VALUES["frequency"] * time + VALUES["phase"]
    parts = zip(HARMONICS, SIZES.values(), strict=True)
    return sum((a * np.sin(n * angle) for n, a in parts), np.zeros(len(time)))


def hum(paper: Model, samples: int) -> Array:
    model = paper.with_link("mains_hum", **VALUES)
    return simulate(model, np.zeros(samples), PERIOD, random=True)


def test_live_it_is_the_series_also_after_an_hour(paper: Model) -> None:
    x = hum(paper, 3_600_000)
    for part in (slice(0, 1000), slice(-1000, None)):
        time = PERIOD * np.arange(3_600_000)[part]
        np.testing.assert_allclose(x[part], series(time), rtol=0.0, atol=1e-15)


def test_predictions_leave_it_out(paper: Model, lively: Array) -> None:
    model = paper.with_link("mains_hum")
    np.testing.assert_array_equal(simulate(model, lively, PERIOD), simulate(paper, lively, PERIOD))


def test_a_harmonic_can_be_there_alone(paper: Model) -> None:
    """A rectifier's ripple has no fundamental."""
    model = paper.with_link("mains_hum", **{**VALUES, "amplitude": 0.0, "third": 0.0, "fifth": 0.0})
    x = simulate(model, np.zeros(4000), PERIOD, random=True)
    time = PERIOD * np.arange(4000)
    expected = 2e-8 * np.sin(2.0 * (2.0 * np.pi * 49.97 * time + 0.9))
    np.testing.assert_allclose(x, expected, rtol=0.0, atol=1e-18)


def test_courses_span_it_whatever_the_phase(paper: Model) -> None:
    time = PERIOD * np.arange(4000)
    columns = link_named("mains_hum").courses(VALUES, time)
    x = hum(paper, 4000)
    weights, *_ = np.linalg.lstsq(columns.T, x, rcond=None)
    np.testing.assert_allclose(weights @ columns, x, atol=1e-17)
    found = link_named("mains_hum").observed(VALUES, weights, time)
    for name in (*SIZES, "phase"):
        assert found[name] == pytest.approx(VALUES[name], rel=1e-9)


def wandering(time: Array, harmonics: Sequence[float], period: float) -> Array:
    """A grid that swings by 20 mHz about its mean, and a hum that a load makes a fifth stronger."""
    slow = 2.0 * np.pi * time / period
    phase = 2.0 * np.pi * 49.99 * time + 0.02 * period * np.sin(slow + 0.7) + 0.4
    size = 1.0 + 0.1 * np.tanh((time - 11.0) / 3.0)
    return size * sum((a * np.sin(n * phase) for n, a in enumerate(harmonics, 1)), 0.0 * time)


@pytest.mark.parametrize(("duration", "left"), [(5.0, 0.03), (20.0, 0.15), (30.0, 0.15)])
def test_a_hum_that_wanders_is_followed_through_the_tenths_not_fitted(
    duration: float, left: float
) -> None:
    time = PERIOD * np.arange(round(duration / PERIOD))
    x = wandering(time, (6e-8, 1e-8, 2e-8), 40.0)
    columns = link_named("mains_hum").courses({"frequency": 49.99}, time)
    fitted = blocks(len(x), odd=True)
    weights, *_ = np.linalg.lstsq(columns[:, fitted].T, x[fitted], rcond=None)
    rest = (x - weights @ columns)[~fitted]
    assert np.sqrt(np.mean(rest**2)) < left * np.std(x)


def test_it_takes_up_next_to_nothing_beside_the_mains() -> None:
    """Noise keeps all but the share of the weights; a line 1 Hz off stays."""
    time = PERIOD * np.arange(20_000)
    columns = link_named("mains_hum").courses({"frequency": 50.0}, time)
    assert len(columns) == 40
    basis = np.linalg.qr(columns.T)[0]
    for other in (49.0, 51.0):
        line = np.sin(2.0 * np.pi * other * time)
        assert np.linalg.norm(basis.T @ line) < 0.1 * np.linalg.norm(line)


@pytest.mark.parametrize("period", [0.01, 0.005, 0.0025])
def test_harmonics_that_fold_back_are_left_out(period: float) -> None:
    """Sampled at 200 Hz the third harmonic would lie on the first: the weights stay determined."""
    time = period * np.arange(4000)
    columns = link_named("mains_hum").courses({"frequency": 49.99}, time)
    assert np.linalg.cond(columns.T) < 1e3
    weights = np.zeros(len(columns))
    weights[0] = 3e-8
    found = link_named("mains_hum").observed({"frequency": 49.99}, weights, time)
    assert found["amplitude"] == pytest.approx(3e-8, rel=1e-3)
    assert found["third"] == 0.0


def test_harmonics_that_fold_back_clear_of_the_first_are_told_apart() -> None:
    """50.05 Hz sampled at 200 Hz: the third shows at 49.85 Hz, the fifth at 50.25 Hz."""
    values = VALUES | {"frequency": 50.05}
    time = 0.005 * np.arange(8000)
    angle = 2.0 * np.pi * 50.05 * time + 0.9
    x = sum((SIZES[name] * np.sin(n * angle) for name, n in (("amplitude", 1), ("fifth", 5))), 0.0)
    columns = link_named("mains_hum").courses(values, time)
    assert np.linalg.cond(columns.T) < 1e3
    weights, *_ = np.linalg.lstsq(columns.T, x, rcond=None)
    found = link_named("mains_hum").observed(values, weights, time)
    assert found["amplitude"] == pytest.approx(6e-8, rel=1e-3)
    assert found["fifth"] == pytest.approx(0.7e-8, rel=1e-2)
    assert found["third"] < 1e-12


def test_the_shortest_recordings_have_courses() -> None:
    for samples in (1, 2, 50):
        columns = link_named("mains_hum").courses(VALUES, PERIOD * np.arange(samples))
        assert columns.shape[1] == samples
        assert np.all(np.isfinite(columns))


@pytest.mark.parametrize("start", [49.9, 50.0, 50.04])
def test_a_planted_hum_is_found(paper: Model, start: float) -> None:
    """The frequency by least squares, the rest linearly beneath it."""
    x = hum(paper, 10_000)
    noisy = x + NOISE * np.random.default_rng(9).normal(size=len(x))
    time = PERIOD * np.arange(len(x))

    def best(frequency: float) -> tuple[Array, Array]:
        columns = link_named("mains_hum").courses({"frequency": frequency}, time)
        weights, *_ = np.linalg.lstsq(columns.T, noisy, rcond=None)
        return weights, noisy - weights @ columns

    fit = least_squares(lambda z: best(float(z[0]))[1] / NOISE, [start], diff_step=1e-7)
    found = float(fit.x[0])
    error = float(np.sqrt(1.0 / (fit.jac.T @ fit.jac).item()))
    assert abs(found - 49.97) < 4.0 * error < 0.015
    weights, residual = best(found)
    sizes = link_named("mains_hum").observed({"frequency": found}, weights, time)
    for name, size in SIZES.items():
        assert sizes[name] == pytest.approx(size, abs=1e-9)
    assert np.std(residual) == pytest.approx(NOISE, rel=0.03)
