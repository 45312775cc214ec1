"""Never in a library: the drive's gain sags with its supply.

Charging the stack empties the supply's store, which recovers over seconds, and the amplifier's gain
follows the supply:

    store' = (1 - store) / recovery - |v'| / (capacity span),   v = u (1 - strength (1 - store))
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
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)


@compiled
def march_sag(p: Array, state: Array, signal: Array) -> None:
    """p: strength, keep, 1 / (capacity span); state: u, what is missing in the store."""
    u0, missing = state[0], state[1]
    for j in range(len(signal)):
        u = signal[j]
        missing = min(missing * p[1] + abs(u - u0) * p[2], 1.0)
        signal[j] = u * (1.0 - p[0] * missing)
        u0 = u
    state[0], state[1] = u0, missing


def sagging_supply(loss: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    keep = exp(-around.step / given["recovery"])
    numbers = np.array([loss, keep, 1.0 / (given["capacity"] * around.scale.span)])
    state = np.zeros(2)

    def run(block: Block) -> None:
        march_sag(numbers, state, block.signal)

    return Element(Slot.VOLTAGE, run)


EFFECT = Effect(
    "supply_sag",
    "drive",
    False,
    (
        Form(
            "a",
            "gain falls as charging empties the supply",
            strength("1", 0.02, 0.6, "gain lost when the store is empty"),
            (
                shape("recovery", "s", 0.8, 4.0, "time constant of the store"),
                shape("capacity", "1", 4.0, 12.0, "ranges that the store can charge"),
            ),
            sagging_supply,
        ),
    ),
)
