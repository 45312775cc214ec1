"""How finely a band-limited voltage is divided between its samples, and what its chords keep."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.plant.bandlimited import course

PERIOD = 1e-3  # s
WHOLE = np.arange(1000)  # sample periods: whole cycles of whole frequencies in Hz


@pytest.mark.parametrize(
    ("frequency", "divisions"), [(0.0, 1), (1.0, 1), (8.0, 2), (40.0, 4), (150.0, 8)]
)
def test_a_period_is_divided_as_the_voltage_bends(frequency: float, divisions: int) -> None:
    voltage = 80.0 + 50.0 * np.cos(2.0 * np.pi * frequency * PERIOD * WHOLE)
    assert course(voltage, periodic=True).divisions == divisions


@pytest.mark.parametrize("frequency", [8.0, 40.0, 150.0])
def test_chords_meet_the_samples_and_have_the_mean_of_the_voltage(frequency: float) -> None:
    """The integral of a sine from sample to sample; uncorrected chords miss it by h^2 u'' / 12."""
    turn = 2.0 * np.pi * frequency * PERIOD
    smooth = course(np.sin(turn * WHOLE), periodic=True)
    table = smooth.corners[:-1].reshape(len(WHOLE), smooth.divisions)
    np.testing.assert_allclose(table[:, 0], np.sin(turn * WHOLE), rtol=0.0, atol=1e-12)
    halves = np.convolve(smooth.corners, [0.5, 0.5], mode="valid").reshape(table.shape)
    expected = (np.cos(turn * WHOLE) - np.cos(turn * (WHOLE + 1.0))) / turn
    uncorrected = (turn / smooth.divisions) ** 2 / 12.0
    np.testing.assert_allclose(halves.mean(axis=1), expected, rtol=0.0, atol=0.02 * uncorrected)
