"""The step of a sensor's grid is read off, and only where there is one."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.grid import (
    common_step,
    noise_under,
    refuted,
    resolution,
    rounding,
)

STEP = 2.1e-7
TIME = 1e-3 * np.arange(20_000)


def loops() -> Array:
    """Loops of 16 um, m, with 15 nm of noise."""
    noise = 15e-9 * np.random.default_rng(5).standard_normal(len(TIME))
    return np.asarray(8e-6 * (1.0 - np.cos(2.0 * np.pi * 0.7 * TIME)) + noise)


def staircase(places: int) -> Array:
    rng = np.random.default_rng(places)
    held = np.repeat(rng.uniform(0.0, 16e-6, places), len(TIME) // places)
    return held + 10e-9 * rng.standard_normal(len(held))


def rounded(position: Array) -> Array:
    return np.asarray(STEP * np.rint(position / STEP))


def test_readings_on_a_grid() -> None:
    assert resolution(rounded(loops()) - 3.3e-8) == pytest.approx(STEP, rel=1e-6)


@pytest.mark.parametrize("share", [0.04, 0.15])
def test_readings_on_a_grid_with_noise_on_top(share: float) -> None:
    noise = share * STEP * np.random.default_rng(6).standard_normal(len(TIME))
    assert resolution(rounded(loops()) + noise) == pytest.approx(STEP, rel=1e-3)


@pytest.mark.parametrize("readings", [loops(), staircase(5), staircase(12), staircase(40)])
def test_readings_on_no_grid(readings: Array) -> None:
    assert resolution(readings) == 0.0


def test_a_weak_grid_that_recordings_share() -> None:
    noise = 0.18 * STEP * np.random.default_rng(7).standard_normal((2, len(TIME)))
    recordings = [rounded(loops()) + noise[0], rounded(0.4 * loops()) + 1.3e-8 + noise[1]]
    assert common_step(recordings) == pytest.approx(STEP, rel=1e-2)


@pytest.mark.parametrize("places", [(5, 7), (12, 15), (40, 41)])
def test_staircases_that_share_no_grid(places: tuple[int, int]) -> None:
    assert common_step([staircase(one) for one in places]) == 0.0


def test_readings_on_steps_that_are_not_alike() -> None:
    bow = 0.1 / np.ptp(loops())  # steps of 0.83 to 1 times the usual one
    bent = rounded(loops() + bow * loops() ** 2)
    assert resolution((np.sqrt(1.0 + 4.0 * bow * bent) - 1.0) / (2.0 * bow)) == pytest.approx(
        0.91 * STEP, rel=0.1
    )


def test_readings_that_are_late_are_on_no_grid() -> None:
    assert resolution(np.repeat(loops()[::8], 8)) == 0.0


def test_a_few_readings_tell_nothing() -> None:
    assert resolution(np.array([0.0, 1e-7, 2e-7, 0.0])) == 0.0


def test_rounding_leaves_a_step_over_the_root_of_twelve() -> None:
    position = np.linspace(0.0, 100.0 * STEP, len(TIME))
    off = float(np.std(rounded(position) - position))
    assert rounding(STEP) == pytest.approx(off, rel=1e-3)


def test_a_staircase_of_equal_steps_is_no_grid_as_the_readings_follow_the_model() -> None:
    """Its positions are a comb; but 15 nm of error are not what steps of 2 um would leave."""
    rng = np.random.default_rng(7)
    held = np.repeat(2e-6 * rng.permutation(16), len(TIME) // 16)
    readings = held + 15e-9 * rng.standard_normal(len(held))
    step = resolution(readings)
    assert step == pytest.approx(2e-6, rel=0.01)
    assert refuted(step, 15e-9, [readings])
    assert not refuted(STEP, rounding(STEP), [rounded(loops())])


def test_a_grid_that_every_reading_lies_on_stays_however_close_a_model_comes() -> None:
    """At eight places a flexible model can follow the rounding; its grid is bowed, too."""
    places = rounded(staircase(8))
    bowed = places + 0.1 * STEP * np.sin(places / 3e-6)
    assert not refuted(STEP, 0.1 * rounding(STEP), [places, bowed])
    assert refuted(STEP, 0.1 * rounding(STEP), [places, staircase(8)])


def test_a_grid_is_what_half_of_the_recordings_show() -> None:
    off, on = loops(), rounded(loops())
    assert common_step([off, off, on]) == 0.0
    assert common_step([off, on]) == pytest.approx(STEP, rel=1e-6)


@pytest.mark.parametrize("noise", [0.0, 40e-9, 100e-9])
def test_the_noise_under_a_grid(noise: float) -> None:
    """Rounding counts as noise until it is known to be rounding; its bow keeps its share."""
    floor = np.hypot(noise, rounding(STEP))
    found = noise_under(float(floor), STEP)
    assert found == pytest.approx(np.sqrt(max(noise**2 - (0.15 * STEP) ** 2, (0.15 * STEP) ** 2)))
    assert noise_under(float(floor), 0.0) == floor
