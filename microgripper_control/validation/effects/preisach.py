"""Never in a library: the wrong kind of hysteresis. Preisach's relays stand in for Bouc and Wen.

A density that factors has a closed Everett integral, E(up, down) = (G(up) - G(down))^2, and the
relays' state is the staircase of past extremes, of which each new one wipes out the smaller ones
(Mayergoyz, Mathematical Models of Hysteresis, 1991). G is the logistic function.

    w -> (1 - strength) w + strength slope d ((1 - loop) u + loop span (relays - relays at 0 V))
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

MOST_EXTREMES = 4096
LOOP = 0.15  # share of the relays in the whole


@compiled
def follow(extremes: Array, sums: Array, place: Array, g: float) -> float:
    """The relays' output after G has gone to g, from 0 (all down) to 1 (all up).

    `extremes` are past minima and maxima of G by turns, beginning with 0, ending with the present
    value; `sums` what each stretch between them has added; place[0] how many there are.
    """
    n = int(place[0])
    move = g - extremes[n - 1]
    if n >= 2 and move * (extremes[n - 1] - extremes[n - 2]) >= 0.0:
        n -= 1
    extremes[n] = g
    n += 1
    while n >= 4 and abs(g - extremes[n - 2]) >= abs(extremes[n - 2] - extremes[n - 3]):
        n -= 2
        extremes[n - 1] = g
    n = min(n, MOST_EXTREMES - 1)
    swing = g - extremes[n - 2]
    sums[n - 1] = sums[n - 2] + swing * abs(swing)
    place[0] = n
    return float(sums[n - 1])


@compiled
def march_relays(
    p: Array, extremes: Array, sums: Array, place: Array, voltage: Array, free: Array
) -> None:
    """p: strength, d, share of the voltage, loop in V, middle and width of G in V, output at 0 V.

    place: how many extremes, last voltage, last output.
    """
    for j in range(len(voltage)):
        u = voltage[j]
        if u != place[1]:
            g = 1.0 / (1.0 + exp(-(u - p[4]) / p[5]))
            place[1], place[2] = u, follow(extremes, sums, place, g)
        free[j] += p[0] * (p[1] * (p[2] * u + p[3] * (place[2] - p[6])) - free[j])


def relays_instead(share: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    scale = around.scale
    middle = 0.5 * (scale.low + scale.high)
    width = given["width"] * scale.span
    extremes, sums = np.zeros(MOST_EXTREMES), np.zeros(MOST_EXTREMES)
    place = np.array([1.0, 0.0, 0.0])
    at_rest = follow(extremes, sums, place, 1.0 / (1.0 + exp(middle / width)))
    place[2] = at_rest
    loop = LOOP * scale.span
    slope = given["slope"]
    numbers = np.array([share, slope * scale.base.d, 1.0 - LOOP, loop, middle, width, at_rest])

    def run(block: Block) -> None:
        march_relays(numbers, extremes, sums, place, block.voltage, block.signal)

    return Element(Slot.FREE, run)


EFFECT = Effect(
    "preisach",
    "material",
    False,
    (
        Form(
            "b",
            "relays instead of Bouc and Wen",
            strength("1", 0.1, 1.0, "share of the relays"),
            (
                shape("width", "1", 0.1, 0.25, "of the logistic function, in ranges"),
                shape("slope", "1", 0.85, 0.95, "of the whole, over d"),
            ),
            relays_instead,
        ),
    ),
)
