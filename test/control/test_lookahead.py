"""The lookahead against motion whose future is known."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.control.lookahead import Lookahead
from microgripper_control.core.signals import Array


def expected_ahead(setpoint: Array, ticks: int = 2) -> Array:
    lookahead = Lookahead(ticks)
    return np.array([lookahead.step(value) for value in setpoint])


@pytest.mark.parametrize("ticks", [0, 1, 2, 5])
def test_a_parabola_is_continued_exactly(ticks: int) -> None:
    k = np.arange(30.0)
    ahead = expected_ahead(1.0 + 3.0 * k + 0.25 * k**2, ticks)
    later = 1.0 + 3.0 * (k + ticks) + 0.25 * (k + ticks) ** 2
    np.testing.assert_allclose(ahead[4:], later[4:], rtol=1e-13)


def test_the_error_on_a_sine_is_of_third_order() -> None:
    worst = []
    for samples in (200, 400, 800):
        k = np.arange(3 * samples)
        ahead = expected_ahead(np.sin(2 * np.pi * k / samples))
        worst.append(np.abs(ahead - np.sin(2 * np.pi * (k + 2) / samples))[10:].max())
    order = np.log2(np.array(worst[:-1]) / np.array(worst[1:]))
    np.testing.assert_allclose(order, 3.0, atol=0.2)


@pytest.mark.parametrize("base", [np.zeros(40), 0.01 * np.arange(40)], ids=["rest", "ramp"])
def test_a_step_is_not_continued(base: Array) -> None:
    setpoint = base + np.where(np.arange(40) >= 20, 1.0, 0.0)
    slope = base[1] - base[0]
    ahead = expected_ahead(setpoint)
    np.testing.assert_allclose(ahead[10:], setpoint[10:] + 2 * slope, atol=1e-12)


def test_one_late_sample_of_a_ramp_does_no_more_than_be_late() -> None:
    ramp = np.arange(40.0)
    late = ramp.copy()
    late[20] = late[19]
    np.testing.assert_allclose(expected_ahead(late)[10:], late[10:] + 2.0)


def test_a_corner_is_overshot_for_two_ticks_and_no_more() -> None:
    setpoint = np.minimum(np.arange(40.0), 40.0 - np.arange(40.0))
    error = expected_ahead(setpoint)[:-2] - setpoint[2:]
    wrong = np.flatnonzero(np.abs(error[5:]) > 1e-12) + 5
    np.testing.assert_array_equal(wrong, [19, 20, 21])
    assert np.abs(error[5:]).max() == 4.0


def test_the_first_setpoint_counts_as_held() -> None:
    lookahead = Lookahead()
    assert lookahead.step(7.0) == 7.0
    lookahead.step(8.0)
    lookahead.step(9.0)
    lookahead.reset()
    assert lookahead.step(70.0) == 70.0
