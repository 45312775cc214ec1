"""Setpoints for the tracking experiments, and how their errors are counted.

The paper gives no setpoint. A sine is used that stays inside what all the plants compared can
reach in cycling, because a piezo that was driven once does not come back to zero.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from microgripper_control.control.setpoints import Ramp, Sequence, Sine
from microgripper_control.core.signals import Array
from microgripper_control.paper.behaviour import at_rest
from microgripper_control.paper.experiment import drive
from microgripper_control.plant.model import Model

GRID = 5e-7  # m: the reach is rounded inwards to it
CYCLES = 10
MISMATCH = 0.1  # share by which the parameters of a plant are off
MISMATCHED = ("d", "alpha", "beta", "gamma")


@dataclass(frozen=True)
class Tracking:
    """An error, % of the setpoint's peak to peak."""

    rms: float
    largest: float


def tracking_error(setpoint: Array, displacement: Array) -> Tracking:
    """Setpoint minus displacement, both m, shape (n,)."""
    error = setpoint - displacement
    share = 100.0 / float(np.ptp(setpoint))
    return Tracking(share * float(np.sqrt(np.mean(error**2))), share * float(np.max(np.abs(error))))


def approached_sine(
    reach: tuple[float, float], frequency: float, cycles: int, sample_period: float
) -> tuple[Array, int]:
    """A sine (Hz) between two displacements, m, after a way to its low end from zero.

    The way there takes a quarter of a period, at least 50 ms up to 10 Hz, and as long again to
    settle. Returns the setpoint and the sample at which the sine begins.
    """
    low, high = reach
    rise = min(max(0.25 / frequency, 0.05), 2.5 / frequency)
    sequence = Sequence(
        (
            (Ramp(low=0.0, high=low, duration=rise), 2.0 * rise),
            (Sine(low=low, high=high, frequency=frequency), cycles / frequency),
        )
    )
    _, start, end = sequence.boundaries(sample_period)
    return sequence.samples(end, sample_period), start


def mismatched(plant: Model, by: float = MISMATCH) -> Iterable[Model]:
    """The plant with d, alpha, beta and gamma each off by that share, all 16 corners."""
    for signs in itertools.product((1.0, -1.0), repeat=len(MISMATCHED)):
        yield plant.with_values(
            {
                ("bouc_wen", name): plant.value("bouc_wen", name) * (1.0 + by * sign)
                for name, sign in zip(MISMATCHED, signs, strict=True)
            }
        )


def common_reach(plants: Iterable[Model]) -> tuple[float, float]:
    """Displacements, m, that each plant can reach at any time in cycling, rounded inwards."""
    low, high = 0.0, math.inf
    for plant in plants:
        displacement = at_rest(plant, drive(plant, cycles=CYCLES))
        period = (len(displacement) - 1) // CYCLES
        low = max(low, float(displacement[::period].max()))
        high = min(high, float(displacement[period // 2 :: period].min()))
    return GRID * math.ceil(low / GRID), GRID * math.floor(high / GRID)
