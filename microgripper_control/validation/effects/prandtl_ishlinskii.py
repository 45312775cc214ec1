"""Never in a library: the wrong kind of hysteresis. Play operators stand in for Bouc and Wen.

    w -> (1 - strength) w + strength d (u0 u - sum of weights play(u, r))

with exponentially falling weights (Kuhnen, Eur. J. Control 9, 2003).
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

THRESHOLDS = np.linspace(0.02, 0.5, 10)  # of the range
LOOP = 0.45  # weights together: a loop about twice as wide as the paper's


@compiled
def march_plays(
    p: Array, thresholds: Array, weights: Array, plays: Array, voltage: Array, free: Array
) -> None:
    """p: strength, d; thresholds in V."""
    for j in range(len(voltage)):
        u = voltage[j]
        total = 0.0
        for i in range(len(thresholds)):
            plays[i] = min(max(plays[i], u - thresholds[i]), u + thresholds[i])
            total += weights[i] * plays[i]
        free[j] += p[0] * (p[1] * (u * (1.0 - LOOP) + total) - free[j])


def plays_instead(share: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    numbers = np.array([share, around.scale.base.d * given["slope"]])
    thresholds = THRESHOLDS * around.scale.span
    weights = np.exp(-THRESHOLDS / given["fall"])
    weights *= LOOP / weights.sum()
    plays = np.zeros(len(thresholds))

    def run(block: Block) -> None:
        march_plays(numbers, thresholds, weights, plays, block.voltage, block.signal)

    return Element(Slot.FREE, run)


EFFECT = Effect(
    "prandtl_ishlinskii",
    "material",
    False,
    (
        Form(
            "a",
            "play operators instead of Bouc and Wen",
            strength("1", 0.1, 1.0, "share of the plays"),
            (
                shape("fall", "1", 0.05, 0.25, "of the weights, in ranges"),
                shape("slope", "1", 0.85, 0.95, "of the whole, over d"),
            ),
            plays_instead,
        ),
    ),
)
