"""Single readings that no rig could have made are found, and nothing that a rig does is."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.clean import cleaned
from microgripper_control.recordings.clock import on_uniform_clock
from microgripper_control.recordings.samples import Samples
from microgripper_control.recordings.spikes import spikes

COUNT = 4000
PERIOD = 1e-3
TIME = PERIOD * np.arange(COUNT)
SINES = 75.0 + 40.0 * np.sin(8.0 * TIME) + 25.0 * np.sin(25.0 * TIME)
STAIRS = np.repeat(np.random.default_rng(1).uniform(0.0, 150.0, COUNT // 50), 50)
PULSES = np.where(np.arange(COUNT) % 200 == 7, 110.0, 75.0)
AT = np.array([400, 1234, 3990])


def measured(
    voltage: Array, model: Model | None = None, noise: float = 10e-9, hold: Hold = Hold.ZERO
) -> Array:
    x = simulate(model or nominal_model(), voltage, PERIOD, hold=hold)
    return np.asarray(x + noise * np.random.default_rng(2).standard_normal(COUNT))


@pytest.mark.parametrize("noise", [0.0, 10e-9])
@pytest.mark.parametrize("size", [1e-6, -2e-6, 0.6e-6])
def test_a_reading_far_from_its_neighbours_is_a_spike(size: float, noise: float) -> None:
    x = measured(SINES, noise=noise)
    x[AT] += size
    assert spikes(SINES, x).tolist() == AT.tolist()


@pytest.mark.parametrize("grid", [0.0, 20e-9, 200e-9])
@pytest.mark.parametrize("noise", [0.0, 10e-9])
@pytest.mark.parametrize("voltage", [SINES, STAIRS, PULSES])
def test_what_a_rig_does_is_no_spike(voltage: Array, noise: float, grid: float) -> None:
    model = nominal_model().with_link("extra_resonance", share=0.3, frequency=400.0, damping=0.01)
    for rig, hold in product((nominal_model(), model), Hold):
        x = measured(voltage, rig, noise, hold)
        x = grid * np.rint(x / grid) if grid else x
        assert len(spikes(voltage, x)) == 0


def test_a_reading_of_another_moment_is_no_spike() -> None:
    """A sensor that is late now and then shows where the rig was, which is the rig's own."""
    fast = 75.0 + 70.0 * np.sin(2.0 * np.pi * 10.0 * TIME)
    x = measured(fast, noise=1e-9)
    late = np.arange(100, COUNT, 200)
    x[late] = x[late - 1]
    assert np.max(np.abs(np.diff(x, 2))) > 0.5e-6
    assert len(spikes(fast, x)) == 0


def test_spikes_that_come_close_are_found_where_there_are_many() -> None:
    x = measured(SINES)
    at = np.sort(np.random.default_rng(9).choice(np.arange(5, COUNT - 5), 30, replace=False))
    at = np.unique([*at, 3004, 3006])
    x[at] += np.random.default_rng(10).uniform(0.4e-6, 3e-6, len(at))
    found = spikes(SINES, x)
    assert np.all(np.isin(at, found))
    others = np.setdiff1d(found, at)
    assert len(others) <= 3
    assert np.all(np.isin(others, [at - 1, at + 1]))  # a good reading between two may go with them


def test_where_there_are_many_they_are_no_accident() -> None:
    x = measured(SINES)
    x[100::60] += 2e-6
    assert len(spikes(SINES, x)) == 0


@pytest.mark.parametrize("count", [10, 11, 12])
def test_a_short_or_resting_recording_has_none(count: int) -> None:
    x = measured(SINES)[:count]
    assert len(spikes(np.full(count, 75.0), x)) == 0
    assert len(spikes(np.full(count, 75.0), np.zeros(count))) == 0


def test_spikes_are_read_as_missing_and_told() -> None:
    x = measured(SINES)
    known = x.copy()
    x[AT] += 2e-6
    recording = cleaned(on_uniform_clock("run", Samples(TIME, SINES, x)))
    assert np.flatnonzero(~recording.counting).tolist() == AT.tolist()
    others = recording.counting
    assert np.array_equal(recording.measured[others], known[others])
    assert recording.measured[AT] == pytest.approx(known[AT], abs=0.2e-6)
    (warning,) = recording.warnings
    assert warning.startswith("spikes: 3 single readings stand far off those around them")
    assert "the first at sample 400; they do not count" in warning
