"""Tracking: a PI controller of the rig's own, one sample after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.validation.block import Array
from microgripper_control.validation.drive import Drive
from microgripper_control.validation.machine import Machine, Rig


@dataclass(frozen=True)
class Controller:
    """u[k+1] = kp e[k] + I[k], the integral held within the range of the voltage."""

    kp: float  # V/m
    ki: float  # V/(m s)
    low: float  # V
    high: float  # V


PROPORTIONAL = 0.02  # loop gain; more would set off a resonance
SOFT_START = 1.0  # s, in which the setpoint leaves the first reading


def tune(bandwidth: float, stroke: float, low: float, high: float) -> Controller:
    """Integral action that crosses over at `bandwidth` (Hz), and a trace of proportional."""
    gain = stroke / (high - low)
    return Controller(PROPORTIONAL / gain, 2.0 * np.pi * bandwidth / gain, low, high)


def track(
    rig: Rig,
    begun: Drive,
    setpoint: Array,
    controller: Controller,
    noise: Array,
    steps: int,
    chance: Sequence[int],
) -> tuple[Drive, Array]:
    """Go through the past of `begun`, then follow `setpoint` (m, one a sample).

    Returns the drive with the voltages that the controller chose, and the readings as recorded, m.
    """
    machine = Machine(rig, begun, steps, chance)
    past = begun.past_samples
    samples = begun.samples.copy()
    period = begun.sample_period
    position = np.zeros(1)
    for j in range(past):
        _settle(machine, position, begun.instant(j - 1))
        position = machine.advance(begun.internal(j, j + 1, steps), begun.instant(j))
    recorded = np.empty(len(setpoint))
    integral = samples[past]
    first = 0.0
    for k in range(len(setpoint)):
        reading = machine.read(position, (k - 1) * period)
        recorded[k] = machine.convert(reading + noise[k], (k - 1) * period)[0]
        if k == 0:
            first = recorded[0]
        position = machine.advance(np.full(steps, samples[past + k]), k * period)
        if k + 1 < len(setpoint):
            leaving = min(k * period / SOFT_START, 1.0)
            error = first + leaving * (setpoint[k] - first) - recorded[k]
            integral += controller.ki * period * error
            integral = min(max(integral, controller.low), controller.high)
            chosen = integral + controller.kp * error
            samples[past + k + 1] = min(max(chosen, controller.low), controller.high)
    return Drive(period, past, samples), recorded


def _settle(machine: Machine, position: Array, time: float) -> None:
    """Let the reading's own memory see the past, as in an open loop."""
    machine.read(position, time)
