"""Views of residuals whose content is known."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.plant.hold import Hold
from microgripper_control.report.residual_views import (
    COLUMNS,
    ROWS,
    Grid,
    Holds,
    answered_voltage,
    over_voltage,
    rate_of,
    spectrum,
    white_density,
)

T = 1e-3
TIME = T * np.arange(20_000)


def recording(voltage: np.ndarray) -> Recording:
    return Recording("r", T, voltage, 1e-7 * voltage)


def test_white_noise_lies_on_its_density() -> None:
    noise = 15e-9 * np.random.default_rng(2).standard_normal(len(TIME))
    found = spectrum(noise, np.ones(len(TIME), bool), T)
    upper = found.density[found.frequency > 20.0]
    assert np.mean(upper**2) ** 0.5 == pytest.approx(white_density(15e-9, T), rel=0.03)


@pytest.mark.parametrize("share", [0.75, 0.25])
def test_white_noise_lies_on_its_density_whatever_part_counts(share: float) -> None:
    rng = np.random.default_rng(2)
    counts = np.repeat(rng.uniform(size=200) < share, 100)
    found = spectrum(15e-9 * rng.standard_normal(len(TIME)), counts, T)
    upper = found.density[found.frequency > 20.0]
    assert np.mean(upper**2) ** 0.5 == pytest.approx(white_density(15e-9, T), rel=0.05)


def test_a_line_stands_at_its_frequency() -> None:
    hum = 10e-9 * np.sin(2.0 * np.pi * 50.0 * TIME)
    found = spectrum(hum, np.ones(len(TIME), bool), T)
    assert found.frequency[np.argmax(found.density)] == pytest.approx(50.0, rel=0.02)
    assert np.all(np.diff(found.frequency) > 0.0)


def test_the_power_of_a_spectrum_is_that_of_the_residual() -> None:
    """Up to the edges of the bands."""
    noise = np.random.default_rng(3).standard_normal(len(TIME))
    found = spectrum(noise, np.ones(len(TIME), bool), T)
    power = np.trapezoid if hasattr(np, "trapezoid") else np.trapz
    assert power(found.density**2, found.frequency) == pytest.approx(1.0, rel=0.03)


def test_under_zero_order_hold_a_sample_answers_to_the_voltage_before() -> None:
    given = recording(np.arange(12.0))
    assert answered_voltage(given, Hold.ZERO).tolist() == [0.0, *range(11)]
    assert answered_voltage(given, Hold.FIRST) is given.voltage


def test_the_map_shows_a_residual_that_is_the_displacement_times_the_direction() -> None:
    given = recording(75.0 * (1.0 - np.cos(2.0 * np.pi * TIME)))
    grid = Grid.of(given.measured, given.voltage, given.sample_period)
    direction = np.sign(rate_of(given.voltage, T))
    mean = grid.mean(given.measured * direction, np.ones(len(TIME), bool))
    assert mean.shape == (ROWS, COLUMNS)
    column = grid.low + (grid.high - grid.low) * (np.arange(COLUMNS) + 0.5) / COLUMNS
    error = np.abs(np.abs(mean) - column)
    seen = np.isfinite(mean) & (np.arange(ROWS)[:, None] != ROWS // 2)  # not at the turns
    assert np.all(mean[ROWS // 2 + 1 :][seen[ROWS // 2 + 1 :]] > 0.0)
    assert np.all(mean[: ROWS // 2][seen[: ROWS // 2]] < 0.0)
    assert np.max(error[seen]) < (grid.high - grid.low) / COLUMNS


def test_a_rate_lies_on_the_map_where_it_is_drawn() -> None:
    given = recording(75.0 * (1.0 - np.cos(2.0 * np.pi * TIME)))
    grid = Grid.of(given.measured, given.voltage, given.sample_period)
    largest = float(np.max(np.abs(rate_of(given.voltage, T))))
    assert [grid.position(rate) for rate in (-largest, 0.0, largest)] == pytest.approx([0, 0.5, 1])


def test_creep_after_steps_up_and_down_is_seen_with_one_sign() -> None:
    steps = np.repeat([0.0, 100.0, 20.0, 60.0, 0.0], 4000)
    given = recording(steps)
    since = T * (np.arange(len(steps)) % 4000)
    sign = np.repeat([0.0, 1.0, -1.0, 1.0, -1.0], 4000)
    creep = 1e-9 * sign * np.log(np.maximum(since, T) / T)
    time, mean = Holds.of(given).course(creep, np.ones(len(steps), bool))
    assert time[-1] == pytest.approx(4.0, rel=0.2)
    np.testing.assert_allclose(mean, 1e-9 * np.log(time / T), atol=1e-15)
    assert np.all(np.diff(mean) > 0.0)


def test_a_voltage_rests_though_a_millivolt_of_noise_was_recorded() -> None:
    steps = np.repeat([0.0, 100.0, 20.0, 60.0, 0.0], 4000)
    noisy = steps + 1e-3 * np.random.default_rng(1).standard_normal(len(steps))
    found, quiet = (Holds.of(recording(voltage)) for voltage in (noisy, steps))
    np.testing.assert_array_equal(found.index, quiet.index)
    np.testing.assert_array_equal(found.sign, quiet.sign)


def test_a_voltage_that_never_rests_has_no_holds() -> None:
    assert len(Holds.of(recording(np.sin(TIME))).index) == 0


def test_branches_are_told_apart() -> None:
    voltage = 75.0 * (1.0 - np.cos(2.0 * np.pi * TIME))
    residual = 1e-9 * np.sign(rate_of(voltage, T))
    for rising, level in ((True, 1e-9), (False, -1e-9)):
        _, mean = over_voltage(residual, voltage, np.ones(len(TIME), bool), rising)
        np.testing.assert_allclose(mean, level, rtol=0.05)  # at the turns a rate is nought
