"""Rising and falling branches that differ beyond what beta and gamma give.

a: generalised play operators whose envelope rises along one tanh and falls along another, as in the
   generalised Prandtl-Ishlinskii model (Al Janaideh, Rakheja and Su, Mechatronics 19, 2009), less
   plays with the mean envelope.
b: a Duhem variable that forgets over a longer way when falling than when rising,
       q' = u' - |u'| q / (way up or down),
   less the same with the mean way (Coleman and Hodgdon, Int. J. Eng. Sci. 24, 1986).
Strength: the weight of the difference, over d.
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
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)

THRESHOLDS = np.array([0.03, 0.08, 0.15])  # of the range


@compiled
def march_generalised_plays(
    p: Array, thresholds: Array, plays: Array, voltage: Array, free: Array
) -> None:
    """p: weight in m/V, middle, half span, V, bend rising, bend falling; plays: (2, n)."""
    for j in range(len(voltage)):
        z = (voltage[j] - p[1]) / p[2]
        rising = p[2] * tanh(p[3] * z) / tanh(p[3])
        falling = p[2] * tanh(p[4] * z) / tanh(p[4])
        mean = 0.5 * (rising + falling)
        for i in range(len(thresholds)):
            r = thresholds[i]
            plays[0, i] = max(rising - r, min(falling + r, plays[0, i]))
            plays[1, i] = max(mean - r, min(mean + r, plays[1, i]))
            free[j] += p[0] * (plays[0, i] - plays[1, i])


def unequal_envelopes(share: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    scale = around.scale
    thresholds = THRESHOLDS * scale.span
    numbers = np.array(
        [
            share * scale.base.d / len(thresholds),
            0.5 * (scale.low + scale.high),
            0.5 * scale.span,
            given["bend_rising"],
            given["bend_falling"],
        ]
    )
    plays = np.zeros((2, len(thresholds)))

    def run(block: Block) -> None:
        march_generalised_plays(numbers, thresholds, plays, block.voltage, block.signal)

    return Element(Slot.FREE, run)


@compiled
def forgotten(q: float, du: float, way: float) -> float:
    """q after a change du of the voltage: exact, as dq/du = 1 - sgn(du) q / way is linear."""
    aim = way if du > 0.0 else -way
    return aim + (q - aim) * exp(-abs(du) / way)


@compiled
def march_two_ways(p: Array, state: Array, voltage: Array, free: Array) -> None:
    """p: weight in m/V, way up, way down, V; state: u, q, q of the mean way."""
    u0, q, mean = state[0], state[1], state[2]
    for j in range(len(voltage)):
        du = voltage[j] - u0
        u0 = voltage[j]
        if du != 0.0:
            q = forgotten(q, du, p[1] if du > 0.0 else p[2])
            mean = forgotten(mean, du, 0.5 * (p[1] + p[2]))
        free[j] += p[0] * (q - mean)
    state[0], state[1], state[2] = u0, q, mean


def unequal_ways(share: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    scale = around.scale
    up = given["way"] * scale.span
    numbers = np.array([share * scale.base.d, up, given["ratio"] * up])
    state = np.zeros(3)

    def run(block: Block) -> None:
        march_two_ways(numbers, state, block.voltage, block.signal)

    return Element(Slot.FREE, run)


EFFECT = Effect(
    "asymmetric_hysteresis",
    "material",
    True,
    (
        Form(
            "a",
            "generalised plays with unequal tanh envelopes",
            strength("1", 0.1, 3.0, "of the plays together, over d"),
            (
                shape("bend_rising", "1", 0.4, 0.9, "of the envelope going up"),
                shape("bend_falling", "1", 1.2, 2.0, "of the envelope going down"),
            ),
            unequal_envelopes,
        ),
        Form(
            "b",
            "Duhem variable with unequal ways up and down",
            strength("1", 0.05, 3.0, "of the variable, over d"),
            (
                shape("way", "1", 0.06, 0.2, "over which it forgets going up, of the range"),
                shape("ratio", "1", 1.8, 3.0, "of the way down to the way up"),
            ),
            unequal_ways,
        ),
    ),
)
