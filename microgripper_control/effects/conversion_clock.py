"""A sensor that converts on a clock of its own: between two conversions its reading is held.

    y(t) = x(c),   c the last conversion at or before t;   conversions are `clock` apart

Digital sensors that average some exposures, or are late by some cycles, work so (the paper's does:
1.5 kHz, four cycles); nothing ties their clock to that of the samples. The links that have a
parameter `clock` share this one. How old the reading at a recording's first sample is belongs to
the recording.
"""

import math
from collections.abc import Mapping

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Prepared

SAME_INSTANT = 1e-9  # of the clock: a conversion so shortly after a sample was due at it

CLOCK = Parameter(
    "clock",
    "s",
    0.0,
    0.0,
    1.0,
    "between conversions of the sensor, if it has a clock of its own, else 0",
    0.0,
    fitted=False,
)


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: the reading, the time until the next conversion, x. It runs straight over a step."""
    steps, row = coefficients.shape[0], 0
    held, at, x = state[0], state[1], state[2]
    for j in range(bus.shape[1]):
        step, clock = coefficients[row, 0], coefficients[row, 1]
        row = row + 1 if row + 1 < steps else 0
        end = bus[POSITION, j]
        if at <= step + SAME_INSTANT * clock:
            # Of several the last is read.
            at += clock * math.floor((step - at) / clock + SAME_INSTANT)
            held = x + (end - x) * min(1.0, at / step)
            at += clock
        at -= step
        x = end
        bus[POSITION, j] = held
    state[0], state[1], state[2] = held, at, x


def prepare(clock: float, age: float, timing: Timing, levels: Array) -> Prepared:
    """For conversions every `clock`, s, and a first reading that is `age`, s, old."""
    rows = [(step, clock) for step in timing.steps]
    state = [levels[POSITION], clock - math.fmod(age, clock), levels[POSITION]]
    return Prepared(np.array(rows), np.array(state), timing.ramped)


def turn_back(prepared: Prepared, duration: float) -> None:
    """Have the clock stand where it stood `duration`, s, ago."""
    clock = prepared.coefficients[0, 1]
    prepared.state[1] = math.fmod(prepared.state[1] + duration, clock)


def says_clock(values: Mapping[str, float]) -> list[str]:
    """The last of the clauses on a link with such a clock, none without one."""
    clock = values["clock"]
    return [f"it is read anew every {quantity(clock, 's')}"] if clock > 0.0 else []
