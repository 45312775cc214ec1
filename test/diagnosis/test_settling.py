"""The first period of a periodic recording does not count; everything of another one does."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.settling import find_period, settled

PERIOD = 1e-3  # s
TIME = PERIOD * np.arange(8000)


def recording(voltage: Array) -> Recording:
    return Recording("given", PERIOD, voltage, voltage * 1e-7)


@pytest.mark.parametrize("samples", [400, 913, 2000])
def test_a_period_is_found_to_the_sample(samples: int) -> None:
    wave = np.sin(2.0 * np.pi * np.arange(8000) / samples)
    assert find_period(80.0 * wave + 20.0 * wave**3) == samples


@pytest.mark.parametrize("samples", [20_011, 90_000])
def test_of_a_long_recording_too(samples: int) -> None:
    wave = np.sin(2.0 * np.pi * np.arange(300_000) / samples)
    assert find_period(80.0 * wave + 20.0 * wave**3) == samples


def test_noise_in_the_reading_of_the_voltage_hides_no_period() -> None:
    noise = np.random.default_rng(5).normal(0.0, 0.5, len(TIME))
    assert find_period(80.0 + 80.0 * np.sin(2.0 * np.pi * TIME) + noise) == pytest.approx(
        1000, abs=3
    )


def test_a_sine_switched_on_counts_from_its_second_period() -> None:
    """As a drive that rests and then jumps into the middle of its sine."""
    voltage = np.where(TIME < 3.0, 0.0, 150.0 * np.sin(2.0 * np.pi * (TIME - 3.1)))
    counted = settled(recording(voltage))
    first = int(np.argmax(counted))
    assert first == pytest.approx(4000, abs=50)
    assert counted[first:].all()


@pytest.mark.parametrize(
    "voltage",
    [
        80.0 + 80.0 * np.sin(2.0 * np.pi * (0.2 + 0.3 * TIME) * TIME),
        80.0 + 80.0 * np.sin(2.0 * np.pi * TIME) * np.exp(-TIME / 3.0),
        80.0 + 10.0 * np.floor(TIME),
        80.0 * np.sin(2.0 * np.pi * TIME / 6.0),
        np.full(8000, 80.0),
    ],
    ids=["chirp", "decaying loops", "staircase", "one period and a third", "rest"],
)
def test_what_is_not_periodic_counts_from_the_start(voltage: Array) -> None:
    assert settled(recording(voltage)).all()
