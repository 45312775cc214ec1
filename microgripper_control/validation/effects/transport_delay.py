"""Pure delay.

a: in the sensor's pipeline, with a conversion clock of its own: the reading is a constant time late
   and is held between conversions (a sixth of the delay apart), as digital laser sensors do
   (Micro-Epsilon optoNCDT 1402: four cycles of a 1.5 kHz clock).
b: in the command's link, with jitter: a delay that wanders by some per cent over half a second, as
   on a shared bus (Nilsson, Real-Time Control Systems with Delays, Lund 1998).
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.chance import slow_course
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
SHORTEST = 0.01  # period of the conversions, in steps: nothing
JITTER_CORNER = 2.0  # Hz
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


def jittery_link(delay: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    line, place = _line(around), np.zeros(1)
    jitter = slow_course(around.generator(), -around.past, around.duration, JITTER_CORNER)

    def run(block: Block) -> None:
        wander = np.clip(given["jitter"] * jitter(block.times), -0.9, 0.9)
        march_delay(line, place, delay / around.step * (1.0 + wander), block.signal)

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
            "command link with jitter",
            strength("s", 2e-3, LONGEST, "mean delay"),
            (shape("jitter", "1", 0.02, 0.1, "standard deviation of the delay over its mean"),),
            jittery_link,
            repeatable=False,
        ),
    ),
)
