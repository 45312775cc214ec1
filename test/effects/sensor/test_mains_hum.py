"""Hum: a Fourier series live, and courses that leave phase and amplitude to the recording."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import link_named
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

VALUES = {"frequency": 49.97, "amplitude": 6e-8, "second": 2e-8, "third": 1e-8, "phase": 0.9}
PERIOD = 1e-3  # s
NOISE = 15e-9  # m


def series(time: Array) -> Array:
    angle = 2.0 * np.pi * VALUES["frequency"] * time + VALUES["phase"]
    amplitudes = (VALUES["amplitude"], VALUES["second"], VALUES["third"])
    return sum((a * np.sin(n * angle) for n, a in enumerate(amplitudes, 1)), np.zeros(len(time)))


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
    model = paper.with_link("mains_hum", **{**VALUES, "amplitude": 0.0, "third": 0.0})
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
    np.testing.assert_allclose(np.hypot(weights[::2], weights[1::2]), [6e-8, 2e-8, 1e-8], rtol=1e-9)


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
    assert abs(found - 49.97) < 4.0 * error < 0.004
    weights, residual = best(found)
    np.testing.assert_allclose(np.hypot(weights[::2], weights[1::2]), [6e-8, 2e-8, 1e-8], atol=1e-9)
    assert np.std(residual) == pytest.approx(NOISE, rel=0.03)
