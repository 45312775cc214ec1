"""Never in a library: an amplifier coupled through a capacitor lets a held voltage sink.

    sunk' = (u - sunk) / leak,   v = u - strength sunk

the reverse of creep: displacement falls while the command stands.
"""

from __future__ import annotations

from math import exp

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.effects.form import (
    Effect,
    Element,
    Form,
    Place,
    Reach,
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)


@compiled
def march_leak(p: Array, state: Array, signal: Array) -> None:
    """p: strength, keep; state: sunk."""
    sunk = state[0]
    for j in range(len(signal)):
        sunk = signal[j] + (sunk - signal[j]) * p[1]
        signal[j] -= p[0] * sunk
    state[0] = sunk


def through_capacitor(share: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    numbers = np.array([share, exp(-around.step / given["leak"])])
    state = np.zeros(1)

    def run(block: Block) -> None:
        march_leak(numbers, state, block.signal)

    return Element(Slot.VOLTAGE, run)


def in_holds(share: float, given: Shape, reach: Reach) -> list[Place]:
    """From a tenth of the time constant to the longest hold."""
    begin = 0.1 * given["leak"]
    return [Place("hold_time_s", begin, reach.hold)] if begin < reach.hold else []


EFFECT = Effect(
    "charge_leak",
    "drive",
    False,
    (
        Form(
            "b",
            "a held voltage sinks",
            strength("1", 0.02, 0.6, "of the voltage that sinks in the end"),
            (shape("leak", "s", 1.0, 8.0, "time constant"),),
            through_capacitor,
            in_holds,
        ),
    ),
)
