"""Confidence against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from microgripper_control.identification.confidence import (
    autocorrelation_time,
    interval,
    spread_of,
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
    found = spread_of(np.stack([np.ones_like(x), x], axis=1), [residual], [0])
    assert found.variances == pytest.approx([variance / 1000, variance / float(x @ x)], rel=1e-9)


def test_confidence_is_infinite_along_what_the_data_cannot_see() -> None:
    column = np.linspace(0.0, 1.0, 50)
    jacobian = np.stack([column, 2.0 * column, np.zeros(50)], axis=1)
    found = spread_of(jacobian, [np.full(50, 0.1)], [0]).variances
    assert np.all(np.isinf(found))


def test_what_shows_as_one_does_not_hide_what_shows_by_itself() -> None:
    """Two columns that are one have a direction of their own, which may be exactly that."""
    one, other = np.eye(50)[:2]
    columns = np.stack([one, one, other], axis=1)
    found = spread_of(columns, [np.full(50, 0.1)], [0]).variances
    assert np.isinf(found[:2]).all()
    assert np.isfinite(found[2])


@pytest.mark.parametrize("noise", [(1.0, 1.0), (30.0, 1.0), (1.0, 30.0), (4.0, 1.0)])
@pytest.mark.parametrize("lengths", [(400, 4000), (12, 400), (6, 8)])
def test_a_line_through_recordings_that_differ_in_noise(
    noise: tuple[float, float], lengths: tuple[int, int]
) -> None:
    """The first recording goes far, the second one hardly; either may be the noisy one."""
    random, draws, hits = np.random.default_rng(14), 1000, 0
    far, near = np.linspace(-8.0, 8.0, lengths[0]), np.linspace(-1.0, 1.0, lengths[1])
    x = np.concatenate([far, near])
    for _ in range(draws):
        parts = [size * random.standard_normal(n) for size, n in zip(noise, lengths, strict=True)]
        y = np.concatenate([part - part.mean() for part in parts])  # each has its own zero
        slope = float(x @ y) / float(x @ x)
        left = np.split(y - slope * x, lengths[:1])
        found = spread_of(x[:, None], left, [1, 1])
        low, high = interval(slope, float(found.variances[0]), float(found.freedom[0]))
        hits += low <= 0.0 <= high
    # Few samples look correlated by chance, or less so than they are worth.
    assert (0.93 if min(lengths) > 100 else 0.88) <= hits / draws


def test_recordings_of_one_noise_count_as_one_of_them_all() -> None:
    random = np.random.default_rng(15)
    columns = random.standard_normal((3000, 2))
    residual = random.standard_normal(3000)
    whole = spread_of(columns, [residual], [0])
    parts = spread_of(columns, np.split(residual, [1000, 1700]), [0, 0, 0])
    assert parts.variances == pytest.approx(whole.variances, rel=0.1)
    assert parts.freedom == pytest.approx(whole.freedom, rel=0.1)


def test_white_noise_is_told_from_structure_and_jumps() -> None:
    time = np.linspace(0.0, 1.0, 20_000)
    structure = 50.0 * np.sin(2.0 * np.pi * 5.0 * time) + 100.0 * (time > 0.5)
    noise = 0.3 * np.random.default_rng(13).standard_normal(len(time))
    assert white_noise(structure + noise) == pytest.approx(0.3, rel=0.03)


def test_interval_is_students() -> None:
    low, high = interval(1.0, 0.04, 10)
    assert (low, high) == pytest.approx((1.0 - 2.228139 * 0.2, 1.0 + 2.228139 * 0.2))
