"""Hysteresis of the restoring force over the whole stroke, as in bolted or filled structures.

a: Iwan's distributed element, slip distances in a power law (Segalman, J. Appl. Mech. 72, 2005).
b: Graesser and Cozzarelli's rate-independent damper with a back force (J. Eng. Mech. 117, 1991):
       F' = K (x' - |x'| sgn(F - B) |(F - B) / yield|^n),   B = K back (x - F / K),   n = 3
Strength: K, the stiffness before any slip, over that of the actuator.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array
from microgripper_control.validation.effects.form import (
    Effect,
    Force,
    Form,
    Shape,
    Surroundings,
    shape,
    strength,
)
from microgripper_control.validation.effects.kinds import GRAESSER, IWAN

ELEMENTS = 12
STRIDE = 0.02  # of the yield deflection


@compiled
def iwan(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: number of elements, then stiffness and slip distance of each; state: deflections."""
    force = 0.0
    new[0] = 0.0
    for i in range(int(p[0])):
        limit = p[2 + 2 * i]
        new[1 + i] = min(max(old[1 + i] + x1 - x0, -limit), limit)
        force -= p[1 + 2 * i] * new[1 + i]
    return force


@compiled
def graesser_cozzarelli(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: K in N/m, yield in m (force over K), back; state: carried, force over K in m."""
    z, x = old[1], x0
    strides = 1 + int(abs(x1 - x0) / (STRIDE * p[1]))
    dx = (x1 - x0) / strides
    for _ in range(strides):
        over = (z - p[2] * (x - z)) / p[1]
        first = dx - abs(dx) * over * abs(over) ** 2
        over = (z + first - p[2] * (x + dx - z - first)) / p[1]
        z += 0.5 * (first + dx - abs(dx) * over * abs(over) ** 2)
        x += dx
    new[0], new[1] = 0.0, z
    return float(-p[0] * z)


def distributed_slip(share: float, given: Shape, around: Surroundings) -> Force:
    """Form a: elements at slip distances evenly spread up to the widest, stiffer ones first."""
    scale = around.scale
    spread = (np.arange(ELEMENTS) + 0.5) / ELEMENTS
    weights = spread ** given["exponent"]
    stiffness = share * scale.base.stiffness * weights / weights.sum()
    limits = spread * given["widest"] * scale.stroke
    pairs = np.column_stack([stiffness, limits]).ravel()
    return Force(IWAN, np.concatenate([[float(ELEMENTS)], pairs]))


def back_force(share: float, given: Shape, around: Surroundings) -> Force:
    """Form b."""
    scale = around.scale
    numbers = [share * scale.base.stiffness, given["yield_way"] * scale.stroke, given["back"]]
    return Force(GRAESSER, np.array(numbers))


EFFECT = Effect(
    "restoring_force_hysteresis",
    "mechanics",
    True,
    (
        Form(
            "a",
            "Iwan's distributed slip with a power law",
            strength("1", 0.02, 1.0, "stiffness before any slip over the actuator's"),
            (
                shape("exponent", "1", -0.6, 0.0, "of the power law"),
                shape("widest", "1", 0.3, 0.8, "slip distance, of the stroke"),
            ),
            distributed_slip,
        ),
        Form(
            "b",
            "Graesser and Cozzarelli's damper with a back force",
            strength("1", 0.02, 1.0, "stiffness before any slip over the actuator's"),
            (
                shape("yield_way", "1", 0.08, 0.3, "yield force over K, of the stroke"),
                shape("back", "1", 0.05, 0.3, "stiffness of the back force over K"),
            ),
            back_force,
        ),
    ),
)
