"""Confidence against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from microgripper_control.identification.confidence import (
    autocorrelation_time,
    interval,
    variances_of,
    white_noise,
)


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.9])
def test_autocorrelation_time_of_a_first_order_process(phi: float) -> None:
    white = np.random.default_rng(11).standard_normal(200_000)
    process = lfilter([1.0], [1.0, -phi], white)
    assert autocorrelation_time(process) == pytest.approx((1.0 + phi) / (1.0 - phi), rel=0.1)


def test_the_variances_of_a_straight_line_are_the_textbook_ones() -> None:
    x = np.linspace(-1.0, 1.0, 1000)
    residual = np.random.default_rng(12).choice([-0.1, 0.1], 1000)
    variance = float(residual @ residual) / (1000 - 2) * autocorrelation_time(residual)
    found = variances_of(np.stack([np.ones_like(x), x], axis=1), [residual], offsets=0)
    assert found == pytest.approx([variance / 1000, variance / float(x @ x)], rel=1e-9)


def test_confidence_is_infinite_along_what_the_data_cannot_see() -> None:
    column = np.linspace(0.0, 1.0, 50)
    jacobian = np.stack([column, 2.0 * column, np.zeros(50)], axis=1)
    found = variances_of(jacobian, [np.full(50, 0.1)], offsets=0)
    assert np.all(np.isinf(found))


def test_what_shows_as_one_does_not_hide_what_shows_by_itself() -> None:
    """Two columns that are one have a direction of their own, which may be exactly that."""
    one, other = np.eye(50)[:2]
    found = variances_of(np.stack([one, one, other], axis=1), [np.full(50, 0.1)], offsets=0)
    assert np.isinf(found[:2]).all()
    assert np.isfinite(found[2])


def test_white_noise_is_told_from_structure_and_jumps() -> None:
    time = np.linspace(0.0, 1.0, 20_000)
    structure = 50.0 * np.sin(2.0 * np.pi * 5.0 * time) + 100.0 * (time > 0.5)
    noise = 0.3 * np.random.default_rng(13).standard_normal(len(time))
    assert white_noise(structure + noise) == pytest.approx(0.3, rel=0.03)


def test_interval_is_students() -> None:
    low, high = interval(1.0, 0.04, 10)
    assert (low, high) == pytest.approx((1.0 - 2.228139 * 0.2, 1.0 + 2.228139 * 0.2))
