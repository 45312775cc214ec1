"""Runs of the rig over a given voltage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.validation.block import Array
from microgripper_control.validation.drive import Drive
from microgripper_control.validation.machine import Machine, Rig

STEPS_A_CALL = 200_000  # internal steps marched together: what fits the processor's cache
EXPECTATIONS = 32  # draws of the noise over which a converter's output is averaged


def run(
    rig: Rig,
    drive: Drive,
    steps: int,
    chance: Sequence[int],
    shift: float = 0.0,
) -> tuple[Machine, Array]:
    """March the rig over a drive with `steps` internal steps a sample.

    Returns the machine, for its converter, and the readings without noise from the recording's
    first sample on, m. x[k] answers to u[.. k-1]; the last sample of the drive is never applied.
    `shift` (m) is added to the hysteresis variable at the recording's first sample.
    """
    machine = Machine(rig, drive, steps, chance)
    total = len(drive)
    positions = np.zeros(total)
    samples = max(STEPS_A_CALL // steps, 1)
    first = 0
    while first < total - 1:
        if first == drive.past_samples and shift:
            machine.shift_hysteresis(shift)
        last = min(first + samples, total - 1)
        if first < drive.past_samples:
            last = min(last, drive.past_samples)
        voltage = drive.internal(first, last, steps)
        positions[first + 1 : last + 1] = machine.advance(voltage, drive.instant(first))
        first = last
    readings = machine.read(positions, drive.instant(-1))
    return machine, readings[drive.past_samples :]


def measure(machine: Machine, readings: Array, noise: Array, sample_period: float) -> Array:
    """Readings as recorded, m: with the sensor's noise (m), and through its converter."""
    return machine.convert(readings + noise, -sample_period)


def expected(
    rig: Rig, drive: Drive, steps: int, chance: Sequence[int], noise: float, shift: float = 0.0
) -> Array:
    """What a recording would read on average over the sensor's noise (its standard deviation, m).

    Where the rig has a converter the noise decides what it does, and draws are averaged; no other
    prediction comes closer to the recording. Being draws, they add 1 / (2 `EXPECTATIONS`) to the
    rms of what is left.
    """
    machine, readings = run(rig, drive, steps, chance, shift)
    if not machine.converts:
        return readings
    generator = np.random.default_rng(EXPECTATIONS)
    total = np.zeros_like(readings)
    for _ in range(EXPECTATIONS):
        fresh = Machine(rig, drive, steps, chance)
        drawn = noise * generator.standard_normal(len(readings))
        total += measure(fresh, readings, drawn, drive.sample_period)
    return total / EXPECTATIONS
