"""A loop that widens with the rate.

a: a second Bouc-Wen variable whose feed grows as a power of the rate, smoothed over 10 ms:
       h2' = strength (rate / span)^power alpha d u' - beta |u'| h2 - gamma u' |h2|
   (power laws of the coercive field: Merz, Phys. Rev. 95, 1954; Scott, Integr. Ferroelectr. 12).
b: play operators whose thresholds grow with the rate, less the same with thresholds at rest, as in
   the rate-dependent Prandtl-Ishlinskii model (Al Janaideh, Su and Rakheja, Smart Mater. Struct.
   17, 2008).
Strength a: the loop's growth at one range a second; b: the added plays' share of d.
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

MEMORY = 0.01  # s, over which the rate is smoothed
THRESHOLDS = np.array([0.02, 0.05, 0.1, 0.18])  # of the range, at rest


@compiled
def march_fed_by_rate(p: Array, state: Array, voltage: Array, free: Array) -> None:
    """p: strength alpha d, beta, gamma, power, keep, 1 / (span step); state: u, rate, h2."""
    u0, rate, h = state[0], state[1], state[2]
    for j in range(len(voltage)):
        du = voltage[j] - u0
        u0 = voltage[j]
        before = rate
        rate = p[4] * rate + (1.0 - p[4]) * abs(du) * p[5]
        if du != 0.0:
            feed = p[0] * (0.5 * (before + rate)) ** p[3]
            parts = 1 + int(abs(du))
            for _ in range(parts):
                part = du / parts
                slope = feed * part - p[1] * abs(part) * h - p[2] * part * abs(h)
                guess = h + slope
                h += 0.5 * (slope + feed * part - p[1] * abs(part) * guess)
                h -= 0.5 * p[2] * part * abs(guess)
        free[j] -= h
    state[0], state[1], state[2] = u0, rate, h


def power_of_rate(growth: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    base = around.scale.base
    numbers = np.array(
        [
            growth * base.alpha * base.d,
            base.beta,
            base.gamma,
            given["power"],
            exp(-around.step / MEMORY),
            1.0 / (around.scale.span * around.step),
        ]
    )
    state = np.zeros(3)

    def run(block: Block) -> None:
        march_fed_by_rate(numbers, state, block.voltage, block.signal)

    return Element(Slot.FREE, run)


@compiled
def march_widening_plays(
    p: Array, thresholds: Array, state: Array, plays: Array, voltage: Array, free: Array
) -> None:
    """p: weight in m/V, power, keep, 1 / (span step), knee; plays: (2, n); state: u, rate."""
    u0, rate = state[0], state[1]
    for j in range(len(voltage)):
        u = voltage[j]
        rate = p[2] * rate + (1.0 - p[2]) * abs(u - u0) * p[3]
        widening = 1.0 + (rate / p[4]) ** p[1]
        u0 = u
        for i in range(len(thresholds)):
            r = thresholds[i]
            wide = r * widening
            plays[0, i] = min(max(plays[0, i], u - wide), u + wide)
            plays[1, i] = min(max(plays[1, i], u - r), u + r)
            free[j] += p[0] * (plays[0, i] - plays[1, i])
    state[0], state[1] = u0, rate


def widening_plays(share: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    span = around.scale.span
    thresholds = THRESHOLDS * span
    numbers = np.array(
        [
            share * around.scale.base.d / len(thresholds),
            given["power"],
            exp(-around.step / MEMORY),
            1.0 / (span * around.step),
            given["knee"],
        ]
    )
    state, plays = np.zeros(2), np.zeros((2, len(thresholds)))

    def run(block: Block) -> None:
        march_widening_plays(numbers, thresholds, state, plays, block.voltage, block.signal)

    return Element(Slot.FREE, run)


EFFECT = Effect(
    "rate_dependent_hysteresis",
    "material",
    True,
    (
        Form(
            "a",
            "second Bouc-Wen variable fed by a power of the rate",
            strength("1", 0.1, 5.0, "growth of the loop at one range a second"),
            (shape("power", "1", 0.2, 0.45, "exponent of the rate"),),
            power_of_rate,
        ),
        Form(
            "b",
            "play operators whose thresholds grow with the rate",
            strength("1", 0.05, 3.0, "of the plays together, over d"),
            (
                shape("power", "1", 0.3, 0.7, "exponent of the rate"),
                shape("knee", "1/s", 1.0, 10.0, "ranges a second at which thresholds double"),
            ),
            widening_plays,
        ),
    ),
)
