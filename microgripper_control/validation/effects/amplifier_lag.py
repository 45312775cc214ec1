"""Amplifier dynamics.

a: a Bessel low-pass of fourth order (Thomson, Proc. IEE 96, 1949), as measuring amplifiers use
   because it hardly overshoots; strength is its delay at low frequency.
b: a first RC stage, then the output resistance into the stack, whose large-signal capacitance grows
   with the voltage (Goldfarb and Celanovic, ASME J. Dyn. Syst. Meas. Control 119, 1997, put the
   capacitance there; soft ceramics gain tens of per cent over their range):
       t1 v1' = u - v1,   t2 (1 + growth (v - low) / span) v' = v1 - v
   strength is t1 + t2.
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
def march_two_stages(p: Array, state: Array, slant: Array, signal: Array) -> None:
    """p: steps over t1, steps over t2, growth, low, span; state: u, v1, v."""
    u0, v1, v = state[0], state[1], state[2]
    for j in range(len(signal)):
        u1 = signal[j]
        before = v1
        v1 = relaxed(v1, u1 - slant[j] * (u1 - u0), u1, p[0])
        between = max(slant[j], slant_of_lag(p[0]))
        steps = p[1] / (1.0 + p[2] * (v - p[3]) / p[4])
        v = relaxed(v, v1 - between * (v1 - before), v1, steps)
        slant[j] = max(between, slant_of_lag(steps))
        signal[j] = v
        u0 = u1
    state[0], state[1], state[2] = u0, v1, v


def into_capacitance(total: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    first = given["first_share"] * total
    numbers = np.array(
        [
            around.step / first,
            around.step / (total - first),
            given["growth"],
            around.scale.low,
            around.scale.span,
        ]
    )
    state = np.zeros(3)

    def run(block: Block) -> None:
        march_two_stages(numbers, state, block.slant, block.signal)

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
            "RC stage, then a resistance into a capacitance that grows with the voltage",
            strength("s", 1e-3, 0.05, "sum of both time constants"),
            (
                shape("first_share", "1", 0.2, 0.5, "of the first stage in the sum"),
                shape("growth", "1", 0.2, 0.6, "of the capacitance over the range"),
            ),
            into_capacitance,
        ),
    ),
)
