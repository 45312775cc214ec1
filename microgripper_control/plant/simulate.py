"""Simulation of a model: a whole array at once, or sample by sample.

The sampled-data convention: at tick k the plant reads x[k], latches u[k], applies it from t[k] on
and holds it until t[k+1]. So x[k] answers to u[0..k-1].
"""

from __future__ import annotations

import enum
import threading
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from microgripper_control.core.errors import MicrogripperError, TooStiffError
from microgripper_control.core.signals import (
    HYSTERESIS,
    LEVELS,
    POSITION,
    ROWS,
    VOLTAGE,
    Array,
    Timing,
)
from microgripper_control.effects.material.bouc_wen import FROM_REST
from microgripper_control.effects.registry import registry
from microgripper_control.plant.bandlimited import Course, course
from microgripper_control.plant.chain import Chain
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model

LONG_REST = 256  # sample periods: a shorter one is simulated as any other
BLOCK = 16384  # internal steps on the bus at a time: it stays in the cache, whatever the length
_KEPT = threading.local()

# drive(bus, begin): fill in the voltage of a block that begins at the sample `begin`.
Drive = Callable[[Array, int], None]


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
    reading_age: float = 0.0,
) -> Array:
    """Displacement at the sampling instants, m, shape (n,), for a voltage, V, shape (n,).

    `initial_hysteresis` (m) is h at the first sample, for `Initial.FIRST_SAMPLE`. `random` includes
    the links that draw random numbers; without it the result is the model's prediction.
    `reading_age` (s) is how old the first reading is, for a sensor with a clock of its own. NaN
    where the model is too stiff: a fit that comes by turns back.
    """
    voltage = np.ascontiguousarray(voltage, dtype=float)
    if voltage.ndim != 1 or len(voltage) < 2 or not np.all(np.isfinite(voltage)):
        raise MicrogripperError("voltage: at least two finite samples in one row are needed")
    ramped = hold is not Hold.ZERO
    levels = _initial_levels(voltage, ramped, initial, initial_hysteresis)
    periodic = initial is Initial.PERIODIC
    driven = np.append(voltage, voltage[0]) if periodic else voltage
    smooth = course(voltage, periodic) if hold is Hold.BANDLIMITED else None
    try:
        chain = Chain(
            model,
            sample_period,
            levels,
            hold=hold,
            divisions=smooth.divisions if smooth else 1,
            random=random,
            reading_age=reading_age,
        )
    except TooStiffError:
        return np.full(len(voltage), np.nan)
    drive = _drive(driven, chain.timing, hold, smooth)
    positions = np.empty(len(voltage))
    if periodic:
        bus = np.zeros((ROWS, len(voltage) * chain.steps))
        drive(bus, 0)
        positions[0] = chain.settle(bus)
        positions[1:] = bus[POSITION, chain.steps - 1 : -chain.steps : chain.steps]
    else:
        positions[0] = chain.rest_position
        rests = _rests(voltage) if chain.is_laborious and smooth is None else []
        _run(chain, drive, rests, positions[1:])
    return chain.sense(positions)


def sensed(model: Model, name: str, positions: Array, sample_period: float) -> Array:
    """What one link of a model that acts on samples makes of positions, m, shape (n,)."""
    link = registry()[name]
    timing = Timing.divide(sample_period, {0.0}, set(), ramped=False)
    prepared = link.prepare(model.values(name), timing, np.zeros(LEVELS))
    bus = np.zeros((ROWS, len(positions)))
    bus[POSITION] = positions
    link.kernel(prepared.coefficients, prepared.state, bus)
    shown: Array = bus[POSITION]
    return shown


def _run(chain: Chain, drive: Drive, rests: Sequence[slice], positions: Array) -> None:
    """Fill in the positions after each sample period, a block of them at a time."""
    most = max(1, BLOCK // chain.steps)
    room = _room(ROWS * chain.steps * min(most, len(positions)))
    for begin, end, resting in _blocks(rests, len(positions), most):
        part = positions[begin:end]
        bus = room[: ROWS * chain.steps * len(part)].reshape(ROWS, -1)
        drive(bus, begin)
        if resting:
            chain.rest(bus)
        else:
            chain.advance(bus)
        part[:] = bus[POSITION, chain.steps - 1 :: chain.steps]


def _room(size: int) -> Array:
    """Memory for a bus, which a thread keeps: that of a fresh array is given out page by page."""
    if size > ROWS * BLOCK:
        return np.empty(size)
    if not hasattr(_KEPT, "room"):
        _KEPT.room = np.empty(ROWS * BLOCK)
    room: Array = _KEPT.room
    return room[:size]


def _rests(voltage: Array) -> list[slice]:
    """The sample periods, many in a row, from whose begin to whose end the voltage is the same."""
    same = np.zeros(len(voltage) + 1, bool)
    np.equal(voltage[1:], voltage[:-1], out=same[1:-1])
    edges = np.flatnonzero(same[1:] != same[:-1])
    return [
        slice(int(begin), int(end))
        for begin, end in edges.reshape(-1, 2)
        if end - begin >= LONG_REST
    ]


def _blocks(rests: Sequence[slice], count: int, most: int) -> Iterator[tuple[int, int, bool]]:
    """Begin and end of at most so many sample periods of `count`, and whether the voltage rests."""
    edges = [0, *(edge for rest in rests for edge in (rest.start, rest.stop)), count]
    for index, (first, last) in enumerate(pairwise(edges)):
        for begin in range(first, last, most):
            yield begin, min(begin + most, last), index % 2 == 1


class Plant:
    """The model run live: `read` the displacement, then `write` the voltage, once a tick each.

    It starts settled at `initial_voltage` (V) with h as in `initial_hysteresis` (m). Raises
    MicrogripperError where the model is too stiff to be followed.
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
        self._voltage, self._end = self._bus[VOLTAGE], self._bus[POSITION, -1:]
        self._reading = self._sample[POSITION]
        self._position = self._chain.rest_position

    def read(self) -> float:
        """x[k], m, as the sensor reports it; each call is one reading."""
        if not self._chain.senses:
            return self._position
        self._reading.fill(self._position)
        self._chain.sense_in_place(self._sample)
        return float(self._reading[0])

    def write(self, voltage: float) -> None:
        """Hold u[k], V, from t[k] to t[k+1]."""
        self._voltage.fill(voltage)
        self._chain.advance(self._bus)
        self._position = self._end.item()


def _initial_levels(voltage: Array, ramped: bool, initial: Initial, hysteresis: float) -> Array:
    levels = np.zeros(ROWS)
    if initial is Initial.FIRST_SAMPLE:
        levels[VOLTAGE], levels[HYSTERESIS] = voltage[0], hysteresis
    elif ramped or initial is Initial.PERIODIC:
        # A smooth voltage has no jump at the first sample: the way there lies before it.
        levels[VOLTAGE], levels[HYSTERESIS] = voltage[0], FROM_REST
    return levels


def _drive(voltage: Array, timing: Timing, hold: Hold, smooth: Course | None) -> Drive:
    """How the voltage runs from sample to sample; `smooth` is its course if it is band-limited."""
    fractions = timing.ends / timing.sample_period

    def drive(bus: Array, begin: int) -> None:
        table = bus[VOLTAGE].reshape(-1, len(fractions))  # a row for each sample
        end = begin + len(table)
        old, new = voltage[begin:end, None], voltage[begin + 1 : end + 1, None]
        if smooth is not None:
            for step, fraction in enumerate(fractions.tolist()):
                table[:, step] = smooth.ends(begin, end, fraction)
        elif hold is Hold.FIRST:
            np.subtract(new, old, out=table)
            table *= fractions
            table += old
        else:
            table[:] = old

    return drive
