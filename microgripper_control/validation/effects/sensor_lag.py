"""The sensor's filter.

a: exposures on the sensor's own clock: each reading is the mean of the last four exposures, held
   until the next is ready (optical triangulation sensors work so).
b: a Butterworth low-pass of third order before the converter.
Strength a: the time that a reading averages over; b: the delay at low frequency (2 / wc).
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
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
from microgripper_control.validation.linear import LinearFilter, state_space

EXPOSURES = 4
SHORTEST = 0.01  # exposure, in steps: nothing


@compiled
def march_exposures(p: Array, state: Array, means: Array, position: Array) -> None:
    """p: exposure in steps; state: collected, steps left, held, x; means: of last exposures.

    Exact for a position that runs straight over each step.
    """
    collected, left, held, x0 = state[0], state[1], state[2], state[3]
    for j in range(len(position)):
        x1 = position[j]
        slope = x1 - x0
        at = 0.0  # where in the step
        while at + left <= 1.0:
            collected += left * (x0 + slope * (at + 0.5 * left))
            at += left
            for i in range(EXPOSURES - 1):
                means[i] = means[i + 1]
            means[EXPOSURES - 1] = collected / p[0]
            held = means.mean()
            collected, left = 0.0, p[0]
        rest = 1.0 - at
        collected += rest * (x0 + slope * (at + 0.5 * rest))
        left -= rest
        position[j] = held
        x0 = x1
    state[0], state[1], state[2], state[3] = collected, left, held, x0


def exposures(window: float, given: Shape, around: Surroundings) -> Element:
    """Form a; the first exposure, before anything has moved, is cut short by the clock's phase."""
    period = max(window / EXPOSURES / around.step, SHORTEST)
    numbers = np.array([period])
    state = np.array([0.0, (1.0 - given["clock_phase"]) * period, 0.0, 0.0])
    means = np.zeros(EXPOSURES)

    def run(block: Block) -> None:
        march_exposures(numbers, state, means, block.signal)

    return Element(Slot.POSITION, run)


def butterworth(delay: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    system = state_space([0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 2.0, 1.0], 0.5 * delay)
    made = LinearFilter(system, around.step)

    def run(block: Block) -> None:
        made.run(block.signal, np.ones_like(block.signal))

    return Element(Slot.POSITION, run)


EFFECT = Effect(
    "sensor_lag",
    "sensor",
    True,
    (
        Form(
            "a",
            "mean of four exposures on a clock of its own",
            strength("s", 2e-3, 0.1, "time that a reading averages over"),
            (shape("clock_phase", "1", 0.0, 1.0, "of the exposures, in periods"),),
            exposures,
        ),
        Form(
            "b",
            "Butterworth low-pass of third order",
            strength("s", 1e-3, 0.05, "delay at low frequency"),
            (),
            butterworth,
        ),
    ),
)
