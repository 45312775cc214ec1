"""The shapes at instants where their value is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from microgripper_control.control.setpoints import Ramp, Sine, Staircase, Step, Triangle

T = 1e-3


def test_a_step_falls_on_its_sample_though_times_round() -> None:
    # 0.3 / 0.1 is 2.9999999999999996 in floating point.
    np.testing.assert_array_equal(Step(1.0, 5.0, start=0.3).samples(5, 0.1), [1, 1, 1, 5, 5])
    assert Step(1.0, 5.0, start=0.0).at(0, T) == 5.0


def test_a_staircase_goes_up_and_down_again() -> None:
    stairs = Staircase(0.0, 3.0, steps=3, hold=2e-3).samples(16, T)
    np.testing.assert_array_equal(stairs[::2], [0, 1, 2, 3, 2, 1, 0, 1])
    np.testing.assert_array_equal(stairs[1::2], stairs[::2])


def test_a_ramp_is_straight_between_its_ends() -> None:
    ramp = Ramp(2.0, 4.0, start=2e-3, duration=4e-3).samples(9, T)
    np.testing.assert_allclose(ramp, [2, 2, 2, 2.5, 3, 3.5, 4, 4, 4])


def test_a_triangle_turns_at_half_its_period() -> None:
    triangle = Triangle(0.0, 2.0, frequency=125.0).samples(17, T)
    np.testing.assert_allclose(triangle, [0, 0.5, 1, 1.5, 2, 1.5, 1, 0.5] * 2 + [0])


def test_a_sine_has_its_frequency_phase_and_range() -> None:
    time = np.arange(5000) * T
    np.testing.assert_allclose(
        Sine(2.0, 6.0, frequency=3.0).samples(5000, T), 4.0 - 2.0 * np.cos(6.0 * np.pi * time)
    )
    middle = Sine(-1.0, 1.0, frequency=3.0, phase=math.pi / 2.0).samples(5000, T)
    np.testing.assert_allclose(middle, np.sin(6.0 * np.pi * time), atol=1e-12)


def test_a_sine_keeps_its_phase_for_days() -> None:
    day = 86_400_000
    assert Sine(0.0, 1.0, frequency=0.25).at(7 * day + 1000, T) == pytest.approx(0.5, abs=1e-6)
