"""Simulation of a model: a whole array at once, or sample by sample.

The sampled-data convention: at tick k the plant reads x[k], latches u[k], applies it from t[k] on
and holds it until t[k+1]. So x[k] answers to u[0..k-1].
"""

from __future__ import annotations

import enum

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import HYSTERESIS, POSITION, ROWS, VOLTAGE, Array, Timing
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.plant.chain import Chain
from microgripper_control.plant.model import Model

BANDLIMITED_DIVISIONS = 8


class Hold(str, enum.Enum):
    """How the voltage runs between its samples."""

    ZERO = "zero"
    FIRST = "first"
    BANDLIMITED = "bandlimited"


class Initial(str, enum.Enum):
    """The state a recording starts in."""

    REST = "rest"  # never driven before: u = 0, h = 0
    FIRST_SAMPLE = "first-sample"  # settled at the first voltage, h as given
    PERIODIC = "periodic"  # the recording is one period of a steady state


def simulate(
    model: Model,
    voltage: Array,
    sample_period: float,
    *,
    hold: Hold = Hold.ZERO,
    initial: Initial = Initial.REST,
    initial_hysteresis: float = 0.0,
    random: bool = False,
) -> Array:
    """Displacement at the sampling instants, m, shape (n,), for a voltage, V, shape (n,).

    `initial_hysteresis` (m) is h at the first sample, for `Initial.FIRST_SAMPLE`. `random` includes
    the links that draw random numbers; without it the result is the model's prediction.
    """
    voltage = np.ascontiguousarray(voltage, dtype=float)
    if voltage.ndim != 1 or len(voltage) < 2 or not np.all(np.isfinite(voltage)):
        raise MicrogripperError("voltage: at least two finite samples in one row are needed")
    ramped = hold is not Hold.ZERO
    levels = _initial_levels(model, voltage, ramped, initial, initial_hysteresis)
    divisions = BANDLIMITED_DIVISIONS if hold is Hold.BANDLIMITED else 1
    chain = Chain(model, sample_period, levels, ramped=ramped, divisions=divisions, random=random)
    periodic = initial is Initial.PERIODIC
    driven = np.append(voltage, voltage[0]) if periodic else voltage
    bus = _bus(driven, chain.timing, hold, periodic)
    if periodic:
        chain.settle(bus)
    else:
        chain.advance(bus)
    ends = bus[POSITION, chain.steps - 1 :: chain.steps]
    positions = np.empty(len(voltage))
    positions[0] = ends[-1] if periodic else chain.rest_position
    positions[1:] = ends[: len(voltage) - 1]
    return chain.sense(positions)


class Plant:
    """The model run live: `read` the displacement, then `write` the voltage, once a tick each.

    It starts settled at `initial_voltage` (V) with h as in `initial_hysteresis` (m).
    """

    def __init__(
        self,
        model: Model,
        sample_period: float,
        initial_voltage: float = 0.0,
        initial_hysteresis: float = 0.0,
    ) -> None:
        levels = np.zeros(ROWS)
        levels[VOLTAGE], levels[HYSTERESIS] = initial_voltage, initial_hysteresis
        self._chain = Chain(model, sample_period, levels, random=True)
        self._bus = np.zeros((ROWS, self._chain.steps))
        self._sample = np.zeros((ROWS, 1))
        self._position = self._chain.rest_position

    def read(self) -> float:
        """x[k], m, as the sensor reports it; each call is one reading."""
        self._sample[POSITION, 0] = self._position
        self._chain.sense_in_place(self._sample)
        return float(self._sample[POSITION, 0])

    def write(self, voltage: float) -> None:
        """Hold u[k], V, from t[k] to t[k+1]."""
        self._bus[VOLTAGE] = voltage
        self._chain.advance(self._bus)
        self._position = self._bus[POSITION, -1]


def _initial_levels(
    model: Model, voltage: Array, ramped: bool, initial: Initial, hysteresis: float
) -> Array:
    levels = np.zeros(ROWS)
    if initial is Initial.FIRST_SAMPLE:
        levels[VOLTAGE], levels[HYSTERESIS] = voltage[0], hysteresis
    elif initial is Initial.PERIODIC:
        levels[VOLTAGE] = voltage[0]
    elif ramped:
        # A smooth voltage has no jump at the first sample: the way there lies before it.
        v = model.values("bouc_wen")
        h = advance(0.0, voltage[0], v["alpha"] * v["d"], v["beta"], v["gamma"], v["n"])
        levels[VOLTAGE], levels[HYSTERESIS] = voltage[0], h
    return levels


def _bus(voltage: Array, timing: Timing, hold: Hold, periodic: bool) -> Array:
    """The bus over the intervals between the samples, with the voltage filled in."""
    fractions = timing.ends / timing.sample_period
    steps = len(fractions)
    bus = np.zeros((ROWS, (len(voltage) - 1) * steps))
    if hold is Hold.ZERO:
        for step in range(steps):
            bus[VOLTAGE, step::steps] = voltage[:-1]
        return bus
    if hold is Hold.FIRST:
        for step, fraction in enumerate(fractions):
            bus[VOLTAGE, step::steps] = voltage[:-1] + fraction * np.diff(voltage)
        return bus
    fine = _bandlimited(voltage, periodic)
    at = (np.arange(len(voltage) - 1)[:, None] + fractions[None, :]).ravel()
    bus[VOLTAGE] = np.interp(at, np.arange(len(fine)) / BANDLIMITED_DIVISIONS, fine)
    return bus


def _bandlimited(voltage: Array, periodic: bool) -> Array:
    """The voltage between its samples, as the band-limited signal through them.

    A recording that is not periodic is continued beyond its ends by point reflection, which keeps
    value and slope, so that nothing rings there.
    """
    from scipy.signal import resample  # takes 0.4 s to import: not for a node

    if periodic:
        fine = resample(voltage[:-1], (len(voltage) - 1) * BANDLIMITED_DIVISIONS)
        return np.append(fine, fine[:1])
    there_and_back = np.concatenate([voltage, 2.0 * voltage[-1] - voltage[-2:0:-1]])
    drift = 2.0 * (voltage[-1] - voltage[0]) * np.arange(len(there_and_back)) / len(there_and_back)
    fine = resample(there_and_back - drift, len(there_and_back) * BANDLIMITED_DIVISIONS)
    count = (len(voltage) - 1) * BANDLIMITED_DIVISIONS + 1
    slope = 2.0 * (voltage[-1] - voltage[0]) / (len(there_and_back) * BANDLIMITED_DIVISIONS)
    result: Array = fine[:count] + slope * np.arange(count)
    return result
