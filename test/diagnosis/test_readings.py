"""Clipped and stale readings are flagged; slow, noisy and rounded ones are not."""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.data.readings import without_dead
from microgripper_control.plant.model import Model, nominal_model

T = 1e-3 * np.arange(4000)
VOLTAGE = 75.0 * (1.0 - np.cos(2.0 * np.pi * T))


def readings(noise: float) -> Array:
    return 1e-7 * VOLTAGE + noise * np.random.default_rng(1).standard_normal(len(T))


def warned(displacement: Array, voltage: Array = VOLTAGE) -> list[str]:
    return checked(displacement, voltage)[1]


def checked(displacement: Array, voltage: Array = VOLTAGE) -> tuple[Recording, list[str]]:
    given = Recording("run.csv", 1e-3, voltage, displacement)
    (recording,), lines, left_out = without_dead([given])
    assert left_out == (recording is not given)
    return recording, lines


@pytest.mark.parametrize("noise", [0.0, 15e-9])
def test_plain_readings_pass(noise: float) -> None:
    assert warned(readings(noise)) == []


def test_a_coarse_grid_passes() -> None:
    assert warned(1e-6 * np.rint(readings(15e-9) / 1e-6)) == []


@pytest.mark.parametrize("late", [1, 6])
def test_a_staircase_on_a_coarse_grid_passes(late: int) -> None:
    voltage = np.repeat(np.random.default_rng(2).uniform(0.0, 150.0, 80), 50)
    shown = 1e-7 * np.concatenate([np.full(late, voltage[0]), voltage[:-late]])
    assert warned(1e-6 * np.rint(shown / 1e-6), voltage) == []


def test_clipped_readings_are_flagged() -> None:
    (line,) = warned(np.minimum(readings(15e-9), 1.3e-5))
    assert "clipped" in line
    assert "run.csv" in line


def test_readings_that_fast_turns_clip_a_few_at_a_time_do_not_count() -> None:
    fast = 75.0 + 70.0 * np.sin(2.0 * np.pi * 23.0 * T)
    noise = 15e-9 * np.random.default_rng(5).standard_normal(len(T))
    recording, (line,) = checked(np.minimum(1e-7 * fast + noise, 1.35e-5), fast)
    assert line.endswith("they look clipped and do not count")
    assert recording.read is not None
    assert not np.any(recording.read[recording.measured == 1.35e-5])


def test_stale_readings_are_flagged() -> None:
    stale = readings(15e-9)
    for start in range(300, 3900, 400):
        stale[start : start + 30] = stale[start]
    (line,) = warned(stale)
    assert "stale" in line
    assert " 261 readings" in line or " 290 readings" in line


def test_clipped_readings_do_not_count() -> None:
    limit = 1.3e-5
    recording, (line,) = checked(np.minimum(readings(15e-9), limit))
    assert line.endswith("they look clipped and do not count")
    assert recording.read is not None
    assert not np.any(recording.read[recording.measured == limit])
    assert np.all(recording.read[limit - 0.3e-6 > 1e-7 * VOLTAGE])


def test_readings_of_a_sensor_that_stood_still_do_not_count() -> None:
    """Also where the voltage makes but one step the while, and rests else."""
    voltage = np.repeat(np.random.default_rng(2).uniform(0.0, 150.0, 20), 200)
    noise = 15e-9 * np.random.default_rng(1).standard_normal(len(voltage))
    shown = 1e-7 * np.append(voltage[0], voltage[:-1]) + noise
    shown[1100:1301] = shown[1100]
    recording, (line,) = checked(shown, voltage)
    assert "200 readings (5.0%)" in line
    assert line.endswith("they look stale and do not count")
    assert recording.read is not None
    assert np.array_equal(np.flatnonzero(~recording.read), np.arange(1101, 1301))


def test_what_a_slow_sensor_repeats_counts() -> None:
    slow = np.repeat(readings(15e-9)[::6], 6)[: len(T)]
    slow[2000:2100] = slow[2000]
    recording, (line,) = checked(slow)
    assert line.endswith("they look stale")
    assert recording.read is None


def test_a_staircase_without_noise_counts() -> None:
    voltage = np.repeat(np.random.default_rng(2).uniform(0.0, 150.0, 20), 200)
    late = 1e-7 * np.concatenate([np.full(5, voltage[0]), voltage[:-5]])
    recording, lines = checked(late, voltage)
    assert lines == []
    assert recording.read is None


@pytest.mark.parametrize(("verdict", "asked"), [("effects", 1), ("unknown", 1), ("parameters", 2)])
@pytest.mark.parametrize(("noise", "silent"), [(15e-9, False), (1e-14, True)])
def test_dead_readings_count_where_nothing_else_is_found(
    verdict: str, asked: int, noise: float, silent: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sensor that stands still is a gap of its own, and no effect of the library.

    Without noise a rig may stand still as well, and effects are tried on that.
    """
    module = import_module("microgripper_control.diagnosis.diagnose")
    stale = readings(15e-9)
    stale[300:500] = stale[300]
    given = Recording("run.csv", 1e-3, VOLTAGE, stale)
    counted, told, untried = [], [], []

    def diagnosed(
        nominal: Model, whole: Evidence, warnings: list[str], *rest: object
    ) -> SimpleNamespace:
        counted.append(bool(whole.fitted[0].counting[400]))
        told.append(warnings[0].endswith(" do not count"))
        untried.append(rest[-1])
        return SimpleNamespace(verdict=verdict, gap=SimpleNamespace(noise_floor=noise))

    monkeypatch.setattr(module, "_diagnosed", diagnosed)
    module.diagnose(nominal_model(), [given])
    assert counted == [False, True][:asked]
    assert told == [True, False][:asked]
    assert untried == [(), () if silent else module.candidate_names()][:asked]
