"""The descent against problems whose bottom is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.fits import descent
from microgripper_control.diagnosis.fits.descent import descend

FREE = np.array([-np.inf, -np.inf]), np.array([np.inf, np.inf])


def rosenbrock(z: Array) -> Array:
    return np.array([10.0 * (z[1] - z[0] ** 2), 1.0 - z[0]])


def its_slopes(z: Array) -> Array:
    return np.array([[-20.0 * z[0], 10.0], [-1.0, 0.0]])


def test_a_bent_valley_is_followed_to_its_end() -> None:
    z, left, used = descend(rosenbrock, its_slopes, np.array([-1.2, 1.0]), FREE, 1e-12, 100)
    np.testing.assert_allclose(z, 1.0, rtol=1e-6)
    np.testing.assert_allclose(left, rosenbrock(z))
    assert used <= 100


def test_ranges_of_different_decades_bend_nothing() -> None:
    """The same steps, whatever the bounds that are not met."""
    far = np.array([-2.0, -1e12]), np.array([2.0, 1e12])
    start = np.array([-1.2, 1.0])
    free = descend(rosenbrock, its_slopes, start, FREE, 1e-12, 100)
    bounded = descend(rosenbrock, its_slopes, start, far, 1e-12, 100)
    np.testing.assert_array_equal(free[0], bounded[0])


@pytest.mark.parametrize("high", [0.3, 0.8])
def test_at_a_bound_it_ends_where_scipy_ends(high: float) -> None:
    bounds = np.array([-2.0, -2.0]), np.array([high, 2.0])
    start = np.array([-1.2, 1.0])
    z, _, _ = descend(rosenbrock, its_slopes, start, bounds, 1e-12, 200)
    expected = least_squares(rosenbrock, start, its_slopes, bounds, xtol=1e-14, ftol=1e-14)
    np.testing.assert_allclose(z, expected.x, atol=1e-5)
    assert z[0] == high


def test_parameters_that_the_data_do_not_tell_apart_do_no_harm() -> None:
    """Two that only show in their sum and one that does not show at all."""
    t = np.linspace(0.0, 1.0, 50)

    def residuals(z: Array) -> Array:
        return np.asarray(np.exp(-(z[0] + z[1]) * t) - np.exp(-3.0 * t))

    def slopes(z: Array) -> Array:
        slope = -t * np.exp(-(z[0] + z[1]) * t)
        return np.column_stack([slope, slope, np.zeros_like(t)])

    wide = np.full(3, -10.0), np.full(3, 10.0)
    z, left, _ = descend(residuals, slopes, np.array([0.5, 0.2, 0.7]), wide, 1e-12, 50)
    assert z[0] + z[1] == pytest.approx(3.0)
    assert z[2] == 0.7
    assert float(left @ left) < 1e-12


def test_where_nothing_is_finite_it_does_not_go() -> None:
    def residuals(z: Array) -> Array:
        return np.array([np.log(z[0]) if z[0] > 0.0 else np.nan, 0.0])

    def slopes(z: Array) -> Array:
        return np.array([[1.0 / z[0]], [0.0]])

    bounds = np.array([-10.0]), np.array([100.0])
    z, left, _ = descend(residuals, slopes, np.array([20.0]), bounds, 1e-12, 50)
    assert z[0] == pytest.approx(1.0)
    assert np.all(np.isfinite(left))
    stuck, _, used = descend(residuals, slopes, np.array([-1.0]), bounds, 1e-12, 50)
    assert stuck[0] == -1.0
    assert used == 1


def test_derivatives_whose_correction_overflows_are_taken_anew(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Nothing of the way is lost, and LAPACK, which would print a line, is not asked."""
    monkeypatch.setattr(descent, "_corrected", lambda slopes, *given: np.full_like(slopes, np.nan))
    z, _, _ = descend(rosenbrock, its_slopes, np.array([-1.2, 1.0]), FREE, 1e-12, 100)
    np.testing.assert_allclose(z, 1.0, rtol=1e-6)
    assert capfd.readouterr() == ("", "")


def test_corrected_derivatives_save_fresh_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two decays and noise: a third fewer, down to the same bottom."""
    t = np.linspace(0.0, 3.0, 400)
    noise = 1e-3 * np.random.default_rng(3).standard_normal(400)
    measured = np.exp(-0.7 * t) + 0.5 * np.exp(-3.0 * t) + noise
    bounds, start = (np.zeros(4), np.full(4, 50.0)), np.array([0.5, 0.3, 0.3, 6.0])
    taken: list[Array] = []

    def residuals(z: Array) -> Array:
        return np.asarray(z[0] * np.exp(-z[1] * t) + z[2] * np.exp(-z[3] * t) - measured)

    def slopes(z: Array) -> Array:
        taken.append(z)
        slow, fast = np.exp(-z[1] * t), np.exp(-z[3] * t)
        return np.column_stack([slow, -z[0] * t * slow, fast, -z[2] * t * fast])

    with_corrections = descend(residuals, slopes, start, bounds, 1e-10, 100)
    saving = len(taken)
    monkeypatch.setattr(descent, "CORRECTED", 0)
    without = descend(residuals, slopes, start, bounds, 1e-10, 100)
    assert saving < 0.7 * (len(taken) - saving)
    np.testing.assert_allclose(with_corrections[0], without[0], rtol=1e-4)
