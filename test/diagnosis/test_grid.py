"""A sensor's grid is read off, and only where there is one; what rounding does is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.answers.comparison import _as_it_foretells
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.data.grid import NO_GRID, Grid, noise_under, refuted
from microgripper_control.diagnosis.data.levels import grid_of
from microgripper_control.diagnosis.search.refit import nominal_trial
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

STEP = 2.1e-7
TIME: Array = 1e-3 * np.arange(20_000, dtype=np.float64)


def common_step(readings: Sequence[Array]) -> float:
    """The step that readings show, whatever the voltage did."""
    return grid_of([Recording("run", 1e-3, np.zeros(len(one)), one) for one in readings]).step


def resolution(readings: Array) -> float:
    return common_step([readings])


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


def with_a_bit_that_sticks(position: Array, step: float) -> Array:
    """Of a converter whose bit of half a `step`, m, is always set: half of all are never read."""
    half = 0.5 * step
    return position + half * (np.floor(position / half) % 2.0 == 0.0)


@pytest.mark.parametrize("lag", [0.0, 5e-3])
def test_a_bit_that_sticks_leaves_bands_and_no_grid(lag: float) -> None:
    """Their density is a comb, too; but within a band the readings go with the voltage."""
    time = 1e-3 * np.arange(12_000)
    voltage = 80.0 - 70.0 * np.cos(2.0 * np.pi * 0.7 * time)
    rig = nominal_model().with_link("sensor_lag", time_constant=lag)
    noise = 12e-9 * np.random.default_rng(5).standard_normal(len(time))
    position = simulate(rig, voltage, 1e-3) + noise
    stuck = Recording("stuck", 1e-3, voltage, with_a_bit_that_sticks(position, 600e-9))
    assert grid_of([stuck]) == NO_GRID
    coarse = 600e-9 * np.rint(position / 600e-9) + 5.0 * noise
    assert grid_of([Recording("coarse", 1e-3, voltage, coarse)]).step == pytest.approx(600e-9, 0.01)


def test_a_few_readings_tell_nothing() -> None:
    assert resolution(np.array([0.0, 1e-7, 2e-7, 1e-7, 0.0] * 2)) == 0.0


def test_rounding_leaves_a_step_over_the_root_of_twelve() -> None:
    position = np.linspace(0.0, 100.0 * STEP, len(TIME))
    off = float(np.std(rounded(position) - position))
    assert Grid.even(STEP).rounding == pytest.approx(off, rel=1e-3)


@pytest.mark.parametrize("owner", [-0.5, 0.5])
def test_what_a_converter_without_each_eighth_code_leaves(owner: float) -> None:
    """The code below a missing one, or above it, stands for both."""
    codes = np.rint(loops() / STEP)
    codes += np.where(codes % 8 == 3, 2.0 * owner, 0.0)
    off = float(np.std(STEP * codes - loops()))
    recording = Recording("run", 1e-3, TIME, np.asarray(STEP * codes))
    assert grid_of([recording]).step == pytest.approx(STEP, rel=1e-6)
    assert grid_of([recording]).rounding == pytest.approx(off, rel=0.1)
    assert off > 1.3 * Grid.even(STEP).rounding


def test_levels_that_a_staircase_passes_over_are_not_missing() -> None:
    held = rounded(staircase(80))
    recording = Recording("run", 1e-3, TIME, held)
    assert grid_of([recording]).step == pytest.approx(STEP, rel=1e-6)
    assert grid_of([recording]).rounding == pytest.approx(Grid.even(STEP).rounding, rel=0.1)


def uneven() -> tuple[Array, Array]:
    """Positions, and readings of them on levels 0.7 to 1.3 steps apart, with noise on top."""
    rng = np.random.default_rng(8)
    levels: Array = np.cumsum(STEP * rng.uniform(0.7, 1.3, 90)) - STEP
    borders = 0.5 * (levels[1:] + levels[:-1])
    shown = levels[np.searchsorted(borders, loops())]
    return loops(), np.asarray(shown + 0.04 * STEP * rng.standard_normal(len(TIME)))


def test_levels_that_are_not_alike_under_noise() -> None:
    position, readings = uneven()
    grid = grid_of([Recording("run", 1e-3, TIME, readings)])
    assert grid.step == pytest.approx(STEP, rel=0.1)
    assert grid.rounding == pytest.approx(np.std(readings - position), rel=0.1)


@pytest.mark.parametrize("readings", [loops(), np.repeat(loops()[::8], 8)])
def test_readings_that_gather_nowhere(readings: Array) -> None:
    """Late ones repeat, but are not come back to."""
    assert grid_of([Recording("run", 1e-3, TIME, readings)]) == NO_GRID


def test_readings_that_gather_where_the_voltage_stays_are_on_no_levels() -> None:
    """The same readings; but this voltage moves from time to time only."""
    _, readings = uneven()
    held = Recording("run", 1e-3, np.asarray(np.floor(TIME / 5e-3)), readings)
    assert grid_of([held]) == NO_GRID


def test_a_staircase_of_equal_steps_is_no_grid_as_the_readings_follow_the_model() -> None:
    """Its positions are a comb; but 15 nm of error are not what steps of 2 um would leave."""
    rng = np.random.default_rng(7)
    held = np.repeat(2e-6 * rng.permutation(16), len(TIME) // 16)
    readings = held + 15e-9 * rng.standard_normal(len(held))
    step = resolution(readings)
    assert step == pytest.approx(2e-6, rel=0.01)
    even = Grid.even(STEP)
    assert refuted(Grid.even(step), 15e-9, [readings])
    assert not refuted(even, even.rounding, [rounded(loops())])


def test_a_grid_that_every_reading_lies_on_stays_however_close_a_model_comes() -> None:
    """At eight places a flexible model can follow the rounding; its grid is bowed, too."""
    places = rounded(staircase(8))
    bowed = places + 0.1 * STEP * np.sin(places / 3e-6)
    grid = Grid.even(STEP)
    assert not refuted(grid, 0.1 * grid.rounding, [places, bowed])
    assert refuted(grid, 0.1 * grid.rounding, [places, staircase(8)])


def test_a_grid_is_what_half_of_the_recordings_show() -> None:
    off, on = loops(), rounded(loops())
    assert common_step([off, off, on]) == 0.0
    assert common_step([off, on]) == pytest.approx(STEP, rel=1e-6)


def test_levels_that_a_staircase_leaps_over_once_or_twice_are_not_missing() -> None:
    """Up and down again: what lies between two places is passed by a leap each way."""
    up = np.repeat(np.sort(np.random.default_rng(8).uniform(0.0, 16e-6, 40)), 250)
    places = np.concatenate([up, up[::-1]])
    noisy = places + 10e-9 * np.random.default_rng(9).standard_normal(len(places))
    recording = Recording("stairs", 1e-3, 1e7 * places, rounded(noisy))
    assert grid_of([recording]) == pytest.approx(Grid.even(STEP), rel=1e-6)


@pytest.mark.parametrize("noise", [0.0, 40e-9, 100e-9])
def test_the_noise_under_a_grid(noise: float) -> None:
    """Rounding counts as noise until it is known to be rounding; its bow keeps its share."""
    grid = Grid.even(STEP)
    floor = np.hypot(noise, grid.rounding)
    found = noise_under(float(floor), grid)
    assert found == pytest.approx(np.sqrt(max(noise**2 - (0.15 * STEP) ** 2, (0.15 * STEP) ** 2)))
    assert noise_under(float(floor), NO_GRID) == floor


@pytest.mark.parametrize(("off", "rounded_still"), [(1.0, True), (1.02, False)])
def test_a_prediction_is_rounded_only_where_that_brings_it_nearer(
    off: float, rounded_still: bool
) -> None:
    """A model that is off by more than a step rounds to the wrong one."""
    paper = nominal_model()
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * 0.7 * TIME)
    recording = Recording("run", 1e-3, voltage, rounded(simulate(paper, voltage, 1e-3)))
    evidence = Evidence.gather([recording], [recording], Conditions(), paper)
    model = paper.with_values({("bouc_wen", "d"): off * paper.value("bouc_wen", "d")})
    trial = nominal_trial(evidence, model.with_link("sensor_quantization", resolution=STEP))
    told = _as_it_foretells(evidence, trial)
    assert ("sensor_quantization" in told.effects) == rounded_still
    assert told.both <= trial.both
