"""Output range of the amplifier.

a: compression by a hyperbolic tangent beyond a knee, wide at the top and narrow at the bottom:
       v = knee + width tanh((u - knee) / width)
   (Rapp's and the tanh model are the usual ones of amplifiers; Cripps, RF Power Amplifiers, 1999).
b: a rail that sags under load, because the supply behind it has a resistance: a quadratic knee at
       rail = high - strength span (1 + sag load)
   where load is the mean charging rate over 30 ms, in ranges a second, at most 1.
Strength is how far the top knee lies below the top of the range, as a share of the range.
"""

from __future__ import annotations

from math import exp, tanh

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

BOTTOM = 0.3  # the bottom knee's distance from its end of the range, of the top's
BOTTOM_WIDTH = 0.06  # of the range
LOAD_MEMORY = 0.03  # s


@compiled
def compress(p: Array, signal: Array) -> None:
    """p: top knee, its width, bottom knee, its width, V."""
    for j in range(len(signal)):
        u = signal[j]
        if u > p[0]:
            signal[j] = p[0] + p[1] * tanh((u - p[0]) / p[1])
        elif u < p[2]:
            signal[j] = p[2] + p[3] * tanh((u - p[2]) / p[3])


def tanh_knees(depth: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    scale = around.scale
    numbers = np.array(
        [
            scale.high - depth * scale.span,
            given["width"] * scale.span,
            # A bottom above rest would offset everything before the first sample is taken.
            min(scale.low + BOTTOM * depth * scale.span, 0.0),
            BOTTOM_WIDTH * scale.span,
        ]
    )

    def run(block: Block) -> None:
        compress(numbers, block.signal)

    return Element(Slot.VOLTAGE, run)


@compiled
def march_rail(p: Array, state: Array, signal: Array) -> None:
    """p: high, depth, sag, half width of the knee, load's memory in steps, span; state: u, load."""
    u0, load = state[0], state[1]
    keep = exp(-1.0 / p[4])
    for j in range(len(signal)):
        u = signal[j]
        load = keep * load + (1.0 - keep) * abs(u - u0) * p[6] / p[5]
        rail = p[0] - p[1] * (1.0 + p[2] * min(load, 1.0))
        over = u - rail + p[3]
        if over >= 2.0 * p[3]:
            signal[j] = rail
        elif over > 0.0:
            signal[j] = u - over * over / (4.0 * p[3])
        u0 = u
    state[0], state[1] = u0, load


def sagging_rail(depth: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    span = around.scale.span
    numbers = np.array(
        [
            around.scale.high,
            depth * span,
            given["sag"],
            given["knee"] * depth * span,
            LOAD_MEMORY / around.step,
            span,
            1.0 / around.step,
        ]
    )
    state = np.zeros(2)

    def run(block: Block) -> None:
        march_rail(numbers, state, block.signal)

    return Element(Slot.VOLTAGE, run)


def beyond_knee(depth: float, given: Shape, reach: Reach) -> list[Place]:
    """From the knee to the highest voltage applied."""
    knee = reach.scale.high - depth * reach.scale.span * (1.0 + given.get("knee", 0.0))
    return [Place("voltage_V", knee, reach.voltage[1])] if knee < reach.voltage[1] else []


EFFECT = Effect(
    "saturation",
    "drive",
    True,
    (
        Form(
            "a",
            "tanh compression beyond a knee, wide at the top, narrow at the bottom",
            strength("1", 0.1, 0.6, "the top knee below the top of the range, share of the range"),
            (shape("width", "1", 0.06, 0.2, "of the top knee, share of the range"),),
            tanh_knees,
            beyond_knee,
        ),
        Form(
            "b",
            "a rail that sags with the charging current",
            strength("1", 0.1, 0.5, "the rail below the top of the range, share of the range"),
            (
                shape("sag", "1", 0.1, 0.5, "of the rail's depth at one range a second"),
                shape("knee", "1", 0.1, 0.3, "half width of the knee, share of the rail's depth"),
            ),
            sagging_rail,
            beyond_knee,
        ),
    ),
)
