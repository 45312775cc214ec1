"""Clipped and stale readings are flagged; slow, noisy and rounded ones are not."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.readings import reading_warnings

T = 1e-3 * np.arange(4000)
VOLTAGE = 75.0 * (1.0 - np.cos(2.0 * np.pi * T))


def readings(noise: float) -> Array:
    return 1e-7 * VOLTAGE + noise * np.random.default_rng(1).standard_normal(len(T))


def warned(displacement: Array, voltage: Array = VOLTAGE) -> list[str]:
    return list(reading_warnings(Recording("run.csv", 1e-3, voltage, displacement)))


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


def test_stale_readings_are_flagged() -> None:
    stale = readings(15e-9)
    for start in range(300, 3900, 400):
        stale[start : start + 30] = stale[start]
    (line,) = warned(stale)
    assert "stale" in line
    assert " 261 readings" in line or " 290 readings" in line
