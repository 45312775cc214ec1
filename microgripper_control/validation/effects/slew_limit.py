"""Current limit of the amplifier into the stack's capacitance.

a: an output stage that sources more than it sinks, gives way softly, and whose load grows with the
   voltage; closed form over a step while the limit is frozen:
       v' = S tanh((u - v) / soft),   S = S0 / (1 + growth (v - low) / span), sinking: sink S
       sinh((u - v) / soft) decays as exp(-S t / soft)
b: a hard limit with foldback: a reservoir lends a higher rate until it is empty, as boost
   capacitors do, and is refilled in 0.2 s.
Strength is the time for the whole range at the lasting rate. After the current limits and peak
currents in makers' data of piezo amplifiers (Fleming, IEEE/ASME Trans. Mechatronics 14, 2009).
"""

from __future__ import annotations

from math import asinh, exp

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

REFILL = 0.2  # s
RESERVE = 0.1  # of the range, what a full reservoir adds
SOFTNESS = 0.005  # of the range


@compiled
def march_soft(p: Array, state: Array, slant: Array, signal: Array) -> None:
    """p: travel per step, sink, growth, low, span, soft; state: v."""
    v = state[0]
    for j in range(len(signal)):
        target = signal[j]
        travel = p[0] / (1.0 + p[2] * (v - p[3]) / p[4])
        if target < v:
            travel *= p[1]
        away = abs(target - v) / p[5]
        if away > 0.0:  # it runs as long as it takes, then stands
            slant[j] = max(slant[j], min(p[5] * (away + 1.0) / travel, 1.0))
        left = p[5] * asinh(0.5 * exp(away - travel / p[5]) * (1.0 - exp(-2.0 * away)))
        v = target - left if target > v else target + left
        signal[j] = v
    state[0] = v


def soft_and_one_sided(traverse: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    scale = around.scale
    numbers = np.array(
        [
            scale.span / traverse * around.step,
            given["sink"],
            given["growth"],
            scale.low,
            scale.span,
            SOFTNESS * scale.span,
        ]
    )
    state = np.zeros(1)

    def run(block: Block) -> None:
        march_soft(numbers, state, block.slant, block.signal)

    return Element(Slot.VOLTAGE, run)


@compiled
def march_foldback(p: Array, state: Array, slant: Array, signal: Array) -> None:
    """p: travel per step, boost, refill per step, reserve in V; state: v, reservoir's content."""
    v, held = state[0], state[1]
    for j in range(len(signal)):
        bound = p[0] * (1.0 + p[1] * held)
        move = min(max(signal[j] - v, -bound), bound)
        v += move
        if move != 0.0:  # it runs as long as it takes, then stands
            slant[j] = max(slant[j], abs(move) / bound)
        borrowed = max(abs(move) - p[0], 0.0)
        held = max(held + (1.0 - held) * p[2] - borrowed / p[3], 0.0)
        signal[j] = v
    state[0], state[1] = v, held


def with_foldback(traverse: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    span = around.scale.span
    numbers = np.array(
        [
            span / traverse * around.step,
            given["boost"],
            around.step / REFILL,
            RESERVE * span,
        ]
    )
    state = np.array([0.0, 1.0])

    def run(block: Block) -> None:
        march_foldback(numbers, state, block.slant, block.signal)

    return Element(Slot.VOLTAGE, run)


def above_slowest(traverse: float, given: Shape, reach: Reach) -> list[Place]:
    """From the lowest limit in either direction up."""
    slowest = reach.scale.span / traverse
    if "sink" in given:
        slowest *= given["sink"] / (1.0 + given["growth"])
    return [Place("rate_V_per_s", slowest, reach.rate)] if slowest < reach.rate else []


EFFECT = Effect(
    "slew_limit",
    "drive",
    True,
    (
        Form(
            "a",
            "soft limit, weaker when sinking, into a capacitance that grows with the voltage",
            strength("s", 0.1, 20.0, "time for the whole range when sourcing at its low end"),
            (
                shape("sink", "1", 0.6, 0.9, "sinking over sourcing"),
                shape("growth", "1", 0.1, 0.4, "of the capacitance over the range"),
            ),
            soft_and_one_sided,
            above_slowest,
        ),
        Form(
            "b",
            "hard limit with a reservoir for peaks, then foldback",
            strength("s", 0.1, 20.0, "time for the whole range at the lasting rate"),
            (shape("boost", "1", 0.5, 2.0, "what a full reservoir adds to the lasting rate"),),
            with_foldback,
            above_slowest,
        ),
    ),
)
