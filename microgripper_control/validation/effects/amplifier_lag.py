"""Amplifier dynamics.

a: a Bessel low-pass of fourth order (Thomson, Proc. IEE 96, 1949), as measuring amplifiers use
   because it hardly overshoots; strength is its delay at low frequency.
b: an output stage whose lower half has more resistance into the stack than its upper half, as where
   a transistor pulls up and a resistor or a weaker transistor pulls down (Horowitz and Hill, The
   Art of Electronics, 1989, chapter 2, on followers that source more than they sink):
       v' = (u - v) / t,   t = t1 while u > v,   t = weaker t1 while u < v
   strength is the mean of both time constants.
"""

from __future__ import annotations

from math import exp

import numpy as np
from scipy.signal import bessel

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
from microgripper_control.validation.linear import LinearFilter, slant_after_jump, state_space


def bessel_amplifier(delay: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    numerator, denominator = bessel(4, 1.0, analog=True, norm="delay")
    padded = [0.0] * (len(denominator) - len(numerator)) + list(numerator)
    system = state_space(padded, list(denominator), delay)
    made = LinearFilter(system, around.step)
    slant = slant_after_jump(system, around.step)

    def run(block: Block) -> None:
        made.run(block.signal, block.slant)
        np.maximum(block.slant, slant, out=block.slant)

    return Element(Slot.VOLTAGE, run)


@compiled
def relaxed(y: float, begin: float, end: float, steps: float) -> float:
    """y after a step in which it follows a line from `begin` to `end`, `steps` time constants."""
    decay = exp(-steps)
    lag = (end - begin) * (1.0 - decay) / steps
    return end - lag + (y - begin) * decay


@compiled
def slant_of_lag(steps: float) -> float:
    """How a lag gets to its value after a jump, by the same mean; `steps` time constants long."""
    return 2.0 * (1.0 / steps - 1.0 / (exp(min(steps, 700.0)) - 1.0)) if steps > 1e-3 else 1.0


@compiled
def march_unequal(p: Array, state: Array, slant: Array, signal: Array) -> None:
    """p: steps over the time constant when sourcing, when sinking; state: u, v."""
    u0, v = state[0], state[1]
    for j in range(len(signal)):
        u1 = signal[j]
        steps = p[0] if u1 > v else p[1]
        v = relaxed(v, u1 - slant[j] * (u1 - u0), u1, steps)
        slant[j] = max(slant[j], slant_of_lag(steps))
        signal[j] = v
        u0 = u1
    state[0], state[1] = u0, v


def unequal_halves(mean: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    sourcing = 2.0 * mean / (1.0 + given["weaker"])
    numbers = around.step / (sourcing * np.array([1.0, given["weaker"]]))
    state = np.zeros(2)

    def run(block: Block) -> None:
        march_unequal(numbers, state, block.slant, block.signal)

    return Element(Slot.VOLTAGE, run)


EFFECT = Effect(
    "amplifier_lag",
    "drive",
    True,
    (
        Form(
            "a",
            "Bessel low-pass of fourth order",
            strength("s", 1e-3, 0.05, "delay at low frequency"),
            (),
            bessel_amplifier,
        ),
        Form(
            "b",
            "one time constant when sourcing, a longer one when sinking",
            strength("s", 1e-3, 0.05, "mean of both time constants"),
            (shape("weaker", "1", 1.2, 1.8, "time constant sinking over sourcing"),),
            unequal_halves,
        ),
    ),
)
