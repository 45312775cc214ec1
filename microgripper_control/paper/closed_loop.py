"""The controllers of this package on a simulated rig, tick by tick, and what they leave."""

from __future__ import annotations

import numpy as np

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.control.identified import Identified
from microgripper_control.control.limits import VoltageLimits
from microgripper_control.control.pid import PidGains
from microgripper_control.core.signals import Array
from microgripper_control.paper.experiment import SAMPLE_PERIOD, SENSOR
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Plant, simulate

UNLIMITED_RATE = 1e9  # V/s: the paper has no limit of the rate


def track(
    rig: Model,
    identified: Identified,
    mode: Mode,
    setpoint: Array,
    gains: PidGains | None = None,
    sample_period: float = SAMPLE_PERIOD,
) -> Array:
    """Where the finger really is, m, shape (n,), while a controller follows a setpoint, m.

    `identified` is what the controller holds of the rig, which it sees through the rig's sensor.
    Sampled as everywhere here: the answer to x[k] and r[k] is applied from t[k+1] on.
    """
    low, high = rig.voltage_range
    limits = VoltageLimits(low=low, high=high, safe=low, rate=UNLIMITED_RATE)
    controller = Controller(identified, sample_period, limits=limits, gains=gains, mode=mode)
    plant = Plant(rig, sample_period)
    voltage = np.empty(len(setpoint))
    answer = controller.start(low)
    for k, wanted in enumerate(setpoint.tolist()):
        read = plant.read()
        voltage[k] = answer
        plant.write(answer)
        answer = controller.step(wanted, read, answer)
    return simulate(rig.without([SENSOR]), voltage, sample_period)
