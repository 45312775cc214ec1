"""Bursts of noise are told from what a rig does, and do not count."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.bursts import bursts
from microgripper_control.recordings.clean import cleaned
from microgripper_control.recordings.clock import on_uniform_clock
from microgripper_control.recordings.samples import Samples

PERIOD, COUNT, NOISE = 1e-3, 8000, 10e-9  # s, samples, m rms
TIME = PERIOD * np.arange(COUNT)
WAVES = 80.0 + 40.0 * np.sin(2.0 * np.pi * 0.7 * TIME) + 20.0 * np.sin(2.0 * np.pi * 2.3 * TIME)
STEPS = np.repeat(np.random.default_rng(2).choice([30.0, 60.0, 90.0, 120.0], COUNT // 200), 200)
LEVELS = {"waves": WAVES, "steps": STEPS}
BEGIN, LONG = (1040, 3050, 6250), 120  # no step of the voltage lies within


def shaken(voltage: Array, times: float) -> Array:
    """Readings, m, with three bursts that are so many times as loud as the noise."""
    rng = np.random.default_rng(3)
    readings = simulate(nominal_model(), voltage, PERIOD) + NOISE * rng.standard_normal(COUNT)
    for begin in BEGIN:
        readings[begin : begin + LONG] += times * NOISE * rng.standard_normal(LONG)
    return readings


@pytest.mark.parametrize("times", [6.0, 30.0])
@pytest.mark.parametrize("course", LEVELS)
def test_bursts_are_found(course: str, times: float) -> None:
    found = bursts(LEVELS[course], shaken(LEVELS[course], times))
    true = np.zeros(COUNT, bool)
    for begin in BEGIN:
        true[begin : begin + LONG] = True
    assert np.mean(found[true]) > 0.95
    assert np.count_nonzero(found & ~true) < 60 * len(BEGIN)


def test_readings_in_bursts_do_not_count() -> None:
    recording = cleaned(on_uniform_clock("run", Samples(TIME, WAVES, shaken(WAVES, 10.0))))
    warning = recording.warnings[-1]  # single readings of a burst that stand out come before it
    assert warning.startswith("bursts of noise: ")
    assert warning.endswith("they do not count")
    assert recording.read is not None
    assert not recording.read[BEGIN[0] : BEGIN[0] + LONG].any()


@pytest.mark.parametrize("course", LEVELS)
def test_even_noise_is_no_burst(course: str) -> None:
    assert not bursts(LEVELS[course], shaken(LEVELS[course], 0.0)).any()


def test_noise_that_belongs_to_a_place_is_no_burst() -> None:
    """As where a finger chatters at what it touches: it comes again each time."""
    readings, rng = shaken(WAVES, 0.0), np.random.default_rng(4)
    high = readings > np.quantile(readings, 0.9)
    readings[high] += 10.0 * NOISE * rng.standard_normal(np.count_nonzero(high))
    assert not bursts(WAVES, readings).any()


def test_what_rings_after_a_step_is_no_burst() -> None:
    voltage = np.repeat(np.random.default_rng(5).uniform(20.0, 140.0, COUNT // 1000), 1000)
    rig = nominal_model().with_link("extra_resonance", share=0.3, frequency=150.0, damping=0.01)
    noise = NOISE * np.random.default_rng(6).standard_normal(COUNT)
    assert not bursts(voltage, simulate(rig, voltage, PERIOD) + noise).any()


def test_rounding_that_flips_is_no_burst() -> None:
    step = 200e-9
    readings = step * np.rint(shaken(STEPS, 0.0) / step)
    assert not bursts(STEPS, readings).any()


def test_few_samples_are_too_few() -> None:
    assert not bursts(WAVES[:50], shaken(WAVES, 9.0)[1000:1050]).any()
