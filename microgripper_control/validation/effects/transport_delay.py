"""Pure delay.

a: in the sensor's pipeline, with a conversion clock of its own: the reading is a constant time late
   and is held between conversions (a sixth of the delay apart), as digital laser sensors do
   (Micro-Epsilon optoNCDT 1402: four cycles of a 1.5 kHz clock).
b: in the command's link, a field bus whose drive interpolates: the command is read once a cycle,
   and the output runs straight from each point to the next (CiA 402, interpolated position mode).
   With u_k the command at t_k = (k + phase) cycle:
       v(t + delay) = u_k + (u_k+1 - u_k) (t - t_k) / cycle   for t_k < t < t_k+1
   so that a ramp is late by exactly the delay.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.delay_line import march_delay
from microgripper_control.validation.effects.form import (
    Effect,
    Element,
    Form,
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)

CONVERSIONS = 6.0  # during the delay
SHORTEST = 0.01  # period of conversions or cycle of a bus, in steps: nothing
LONGEST = 0.1  # s


def _line(around: Surroundings) -> Array:
    return np.zeros(int(2.0 * LONGEST / around.step) + 4)


@compiled
def march_conversions(p: Array, state: Array, signal: Array) -> None:
    """p: period in steps; state: steps until the next conversion, value held, value before."""
    left, held, before = state[0], state[1], state[2]
    for j in range(len(signal)):
        value = signal[j]
        while left <= 1.0:
            held = before + left * (value - before)
            left += p[0]
        left -= 1.0
        signal[j] = held
        before = value
    state[0], state[1], state[2] = left, held, before


def sensor_pipeline(delay: float, given: Shape, around: Surroundings) -> Element:
    """Form a: the conversions' own half period of delay is part of the whole."""
    line, place = _line(around), np.zeros(1)
    period = max(delay / CONVERSIONS / around.step, SHORTEST)
    steps = max(delay / around.step - 0.5 * period, 0.0)
    numbers = np.array([period])
    state = np.array([given["clock_phase"] * period, 0.0, 0.0])

    def run(block: Block) -> None:
        march_delay(line, place, np.full(len(block.signal), steps), block.signal)
        march_conversions(numbers, state, block.signal)

    return Element(Slot.POSITION, run)


@compiled
def march_points(p: Array, state: Array, slant: Array, signal: Array) -> None:
    """p: cycle in steps; state: steps until the next point, the last one, the one before, u."""
    left, point, older, u0 = state[0], state[1], state[2], state[3]
    for j in range(len(signal)):
        u1 = signal[j]
        begin = u1 - slant[j] * (u1 - u0)
        while left <= 1.0:
            older = point
            point = begin + left * (u1 - begin)
            left += p[0]
        left -= 1.0
        signal[j] = point - (point - older) * left / p[0]
        slant[j] = max(slant[j], min(p[0], 1.0))
        u0 = u1
    state[0], state[1], state[2], state[3] = left, point, older, u0


def interpolating_link(delay: float, given: Shape, around: Surroundings) -> Element:
    """Form b: a cycle of the delay is the way from point to point, the rest that to the drive."""
    line, place = _line(around), np.zeros(1)
    cycle = max(given["cycle"] * delay / around.step, SHORTEST)
    steps = max(delay / around.step - cycle, 0.0)
    numbers = np.array([cycle])
    state = np.array([given["cycle_phase"] * cycle, 0.0, 0.0, 0.0])

    def run(block: Block) -> None:
        march_points(numbers, state, block.slant, block.signal)
        march_delay(line, place, np.full(len(block.signal), steps), block.signal)

    return Element(Slot.VOLTAGE, run)


EFFECT = Effect(
    "transport_delay",
    "drive",
    True,
    (
        Form(
            "a",
            "sensor pipeline with a conversion clock of its own",
            strength("s", 2e-3, LONGEST, "mean delay"),
            (shape("clock_phase", "1", 0.0, 1.0, "of the conversions, in periods"),),
            sensor_pipeline,
        ),
        Form(
            "b",
            "command link whose drive interpolates from point to point",
            strength("s", 2e-3, LONGEST, "delay of a ramp"),
            (
                shape("cycle", "1", 0.15, 0.4, "of the bus, over the delay"),
                shape("cycle_phase", "1", 0.0, 1.0, "of the bus, in cycles"),
            ),
            interpolating_link,
        ),
    ),
)
