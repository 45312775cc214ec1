"""The simulated experiment that stands in for the paper's: 0 to 160 V into the actuator of Table 1.

The paper gives neither the course of the voltage nor its rate nor the sampling; chosen here are
five cycles of a sine at 1 Hz, read at 1 kHz, on an actuator that was never driven before. Where a
result depends on that, the section that reports it shows how.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.control.identified import Identified
from microgripper_control.control.setpoints import make_setpoint
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.paper.printed import SENSOR_RESOLUTION
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

SAMPLE_PERIOD = 1e-3  # s
FREQUENCY = 1.0  # Hz
CYCLES = 5
SHAPE = "sine"
SENSOR = "sensor_quantization"


def drive(
    model: Model,
    shape: str = SHAPE,
    cycles: float = CYCLES,
    frequency: float = FREQUENCY,
    sample_period: float = SAMPLE_PERIOD,
) -> Array:
    """Cycles over the model's voltage range, V, from its low end; `shape`: sine or triangle."""
    low, high = model.voltage_range
    signal = make_setpoint(shape, {"low": low, "high": high, "frequency": frequency})
    return signal.samples(round(cycles / (frequency * sample_period)) + 1, sample_period)


def record(
    model: Model, voltage: Array, name: str, sample_period: float = SAMPLE_PERIOD
) -> Recording:
    """What the rig records: displacement by equation (4), m, through the model's sensor."""
    displacement = simulate(model, voltage, sample_period, random=True)
    return Recording(name, sample_period, voltage.copy(), displacement)


def with_paper_sensor(model: Model) -> Model:
    """The model read by the paper's sensor, of 1 µm resolution."""
    return model.with_link(SENSOR, resolution=SENSOR_RESOLUTION)


def hysteresis(model: Model, voltage: Array) -> Array:
    """h after each voltage, m, shape (n,), by equations (2), (3), from rest at 0 V."""
    v = Identified.of(model)
    result = np.empty(len(voltage))
    u = h = 0.0
    for k, new in enumerate(voltage):
        h = advance(h, new - u, v.a, v.beta, v.gamma, v.n)
        u = new
        result[k] = h
    return result
