"""Play between actuator and finger.

a: a gap with a yielding, dragging side: the finger is held by viscous drag and pushed by a spring
   once the gap is crossed (Nordin, Galic and Gutman, Int. J. Adapt. Control Signal Process. 11,
   1997, with the shaft's inertia left out):
       drag y' = push dead(x - y),   dead(e) = e beyond half the gap, less half the gap
   exact over a step in which x runs straight; the looser the gap, the longer drag / push.
b: a worn joint: facets that share the motion, with gaps of different width that are wider in the
   middle of the stroke, where the joint has worn.
Strength: the (mean) gap over the stroke.
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

FACETS = np.array([0.6, 0.8, 1.0, 1.2, 1.4])  # gaps over their mean
GAP_AT_LAG = 0.01  # of the stroke: the gap at which `lag` holds


@compiled
def excess_left(before: float, after: float, steps: float) -> float:
    """How far past the gap x still is, which a finger at rest would see go `before` -> `after`.

    `steps` is the step over drag / push. Where the gap is crossed within the step, the push begins
    there.
    """
    if before < 0.0:
        steps *= after / (after - before)
        before = 0.0
    return before * exp(-steps) + (after - before) * (1.0 - exp(-steps)) / steps


@compiled
def march_dragging(p: Array, state: Array, position: Array) -> None:
    """p: half gap in m, step over drag / push; state: x, y."""
    x, y = state[0], state[1]
    for j in range(len(position)):
        before, x = x - y, position[j]
        if x - y > p[0]:
            y = x - p[0] - excess_left(before - p[0], x - y - p[0], p[1])
        elif x - y < -p[0]:
            y = x + p[0] + excess_left(-before - p[0], y - x - p[0], p[1])
        position[j] = y
    state[0], state[1] = x, y


def dragging_finger(gap: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    lag = given["lag"] * gap / GAP_AT_LAG
    numbers = np.array([0.5 * gap * around.scale.stroke, around.step / lag])
    state = np.zeros(2)

    def run(block: Block) -> None:
        march_dragging(numbers, state, block.signal)

    return Element(Slot.POSITION, run)


@compiled
def march_worn(p: Array, facets: Array, state: Array, position: Array) -> None:
    """p: half of the mean gap, wear, bottom, stroke; state: the facets' positions, m."""
    for j in range(len(position)):
        x = position[j]
        share = min(max((x - p[2]) / p[3], 0.0), 1.0)
        half = p[0] * (1.0 + p[1] * (4.0 * share * (1.0 - share) - 2.0 / 3.0))
        total = 0.0
        for i in range(len(facets)):
            reach = half * facets[i]
            state[i] = min(max(state[i], x - reach), x + reach)
            total += state[i]
        position[j] = total / len(facets)


def worn_joint(gap: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    scale = around.scale
    numbers = np.array([0.5 * gap * scale.stroke, given["wear"], scale.bottom, scale.stroke])
    state = np.zeros(len(FACETS))

    def run(block: Block) -> None:
        march_worn(numbers, FACETS, state, block.signal)

    return Element(Slot.POSITION, run)


EFFECT = Effect(
    "backlash",
    "transmission",
    True,
    (
        Form(
            "a",
            "a gap whose sides yield, with a dragging finger",
            strength("1", 0.003, 0.2, "gap over the stroke"),
            (shape("lag", "s", 2e-4, 1e-3, "drag over push at a gap of 1 % of the stroke"),),
            dragging_finger,
        ),
        Form(
            "b",
            "a worn joint: facets with gaps wider in the middle",
            strength("1", 0.003, 0.2, "mean gap over the stroke"),
            (shape("wear", "1", 0.2, 0.8, "more gap in the middle than the mean, at most"),),
            worn_joint,
        ),
    ),
)
