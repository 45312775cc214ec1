"""Noise of a recorded voltage is taken away, and a jitter that was applied is left alone."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.clean import cleaned
from microgripper_control.recordings.clock import on_uniform_clock
from microgripper_control.recordings.samples import Samples
from microgripper_control.recordings.voltage_noise import voltage_noise

PERIOD, COUNT = 1e-3, 8000  # s, samples
NOISE, FINEST = 0.02, 10e-9  # V, m rms
TIME = PERIOD * np.arange(COUNT)
STEPS = np.repeat(np.random.default_rng(2).uniform(20.0, 140.0, COUNT // 400), 400)
WAVES = 80.0 + 40.0 * np.sin(2.0 * np.pi * 0.7 * TIME) + 20.0 * np.sin(2.0 * np.pi * 2.3 * TIME)


def read(voltage: Array, seed: int, hold: Hold = Hold.ZERO) -> Array:
    """What a sensor reads of the rig, m."""
    noise = FINEST * np.random.default_rng(seed).standard_normal(len(voltage))
    return simulate(nominal_model(), voltage, PERIOD, hold=hold) + noise


@pytest.mark.parametrize(("applied", "left"), [(STEPS, 0.3), (WAVES, 0.5)])
def test_noise_of_a_measured_voltage_is_taken_away(applied: Array, left: float) -> None:
    measured = applied + NOISE * np.random.default_rng(3).standard_normal(COUNT)
    displacement = read(applied, 4)
    noise, smooth = voltage_noise(measured, displacement)
    assert noise == pytest.approx(NOISE, rel=0.15)
    assert np.std(smooth - applied) < left * NOISE
    assert np.max(np.abs(smooth - applied)) < 5.0 * NOISE  # steps stay where they are


def test_a_measured_voltage_does_not_let_the_model_relax() -> None:
    measured = STEPS + NOISE * np.random.default_rng(3).standard_normal(COUNT)
    recording = cleaned(on_uniform_clock("run", Samples(TIME, measured, read(STEPS, 4))))
    assert "mV rms that the displacement does not answer" in recording.warnings[0]
    applied, noisy = (simulate(nominal_model(), v, PERIOD) for v in (STEPS, measured))
    error = simulate(nominal_model(), recording.voltage, PERIOD) - applied
    assert np.std(error) < 0.25 * np.std(noisy - applied)


def test_a_jitter_that_is_applied_is_left_alone() -> None:
    applied = STEPS + NOISE * np.random.default_rng(3).standard_normal(COUNT)
    displacement = simulate(nominal_model(), applied, PERIOD)
    noise, voltage = voltage_noise(applied, displacement)
    assert noise == 0.0
    assert voltage is applied


def test_a_controllers_answer_to_sensor_noise_is_left_alone() -> None:
    """The readings before tell of it, even if the displacement after hardly does."""
    error = FINEST * np.random.default_rng(5).standard_normal(COUNT)
    gain = 2.0e6  # V/m
    applied = WAVES - gain * np.append(0.0, error[:-1])
    displacement = simulate(nominal_model(), applied, PERIOD) + error
    noise, voltage = voltage_noise(applied, displacement)
    assert noise == 0.0
    assert voltage is applied


@pytest.mark.parametrize("voltage", [STEPS, WAVES, np.round(WAVES, 1), np.full(COUNT, 5.0)])
def test_a_commanded_voltage_is_left_alone(voltage: Array) -> None:
    noise, found = voltage_noise(voltage, read(voltage, 6))
    assert noise == 0.0
    assert found is voltage


def test_white_noise_as_an_excitation_is_left_alone() -> None:
    voltage = 80.0 + 10.0 * np.random.default_rng(7).standard_normal(COUNT)
    assert voltage_noise(voltage, read(voltage, 8))[0] == 0.0


def test_blocks_join_without_a_seam() -> None:
    applied = np.tile(WAVES, 10)
    measured = applied + NOISE * np.random.default_rng(9).standard_normal(len(applied))
    noise, smooth = voltage_noise(measured, np.tile(read(WAVES, 4), 10))
    assert noise > 0.0
    seam = slice((1 << 16) - 100, (1 << 16) + 100)
    assert np.std((smooth - applied)[seam]) < 0.5 * NOISE


def test_few_samples_are_too_few_to_tell() -> None:
    measured = STEPS[:60] + NOISE * np.random.default_rng(3).standard_normal(60)
    assert voltage_noise(measured, read(STEPS[:60], 4))[0] == 0.0
