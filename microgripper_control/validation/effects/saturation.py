"""Output range of the amplifier.

a: compression by a hyperbolic tangent beyond a knee, wide at the top and narrow at the bottom:
       v = knee + width tanh((u - knee) / width)
   (Rapp's and the tanh model are the usual ones of amplifiers; Cripps, RF Power Amplifiers, 1999).
b: suppressor diodes across the output, behind the resistance of the output stage: the voltage still
   grows a little beyond the knee (a diode with a series resistance: Banwell and Jayakumar,
   Electron. Lett. 36, 2000; by Wright's omega function, omega + ln omega = z):
       v + width exp((v - knee) / width) = u,   v = u - width omega((u - knee) / width)
Strength is how far the top knee lies below the top of the range, as a share of the range.
"""

from __future__ import annotations

from math import exp, log, tanh

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
BEGINNING = 2.0  # widths below their knee the diodes begin to show
NOTHING = -40.0  # of omega's argument: below, it is less than 1e-17


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
def omega(z: float) -> float:
    """Wright's function by Newton's method, which from these starts is done after five steps."""
    if z < NOTHING:
        return 0.0
    w = exp(z) if z < 1.0 else z - log(z)
    for _ in range(5):
        w *= (1.0 + z - log(w)) / (1.0 + w)
    return w


@compiled
def suppress(p: Array, signal: Array) -> None:
    """p: knee, width, V."""
    u, lost = 0.0, p[1] * omega(-p[0] / p[1])
    for j in range(len(signal)):
        if signal[j] != u:  # a held voltage is worked out once
            u = signal[j]
            lost = p[1] * omega((u - p[0]) / p[1])
        signal[j] = u - lost


def suppressor(depth: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    knee = around.scale.high - depth * around.scale.span
    numbers = np.array([knee, given["bend"] * depth * around.scale.span])

    def run(block: Block) -> None:
        suppress(numbers, block.signal)

    return Element(Slot.VOLTAGE, run)


def beyond_knee(depth: float, given: Shape, reach: Reach) -> list[Place]:
    """From where the top bends to the highest voltage applied."""
    below = BEGINNING * given.get("bend", 0.0)
    knee = reach.scale.high - depth * reach.scale.span * (1.0 + below)
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
            "suppressor diodes behind a resistance",
            strength("1", 0.1, 0.5, "the knee below the top of the range, share of the range"),
            (shape("bend", "1", 0.08, 0.25, "width of the knee over its depth"),),
            suppressor,
            beyond_knee,
        ),
    ),
)
