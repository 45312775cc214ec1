"""Friction in guide or joint.

a: the elasto-plastic bristle (Dupont, Hayward, Armstrong and Altpeter, IEEE Trans. Autom. Control
   47, 2002): LuGre's bristle of deflection z with Stribeck's falling curve, which does not creep
   below the breakaway,
       z' = v (1 - a(z) z / limit),   F = -(stiffness z + damping z'),
       limit = sgn(v) force (1 + excess exp(-(v / slow)^2)) / stiffness
   where a rises smoothly, as 3 s^2 - 2 s^3, from 0 at |z| = `elastic` limit to 1 at the limit, and
   is 0 on the way back.
b: Maxwell slip: springs in parallel, each with a slider that gives way at its own deflection
   (Lampaert, Swevers and Al-Bender, IEEE Trans. Autom. Control 47, 2002).
Strength: the sliding force over what would hold the actuator back by its whole stroke.
"""

from __future__ import annotations

from math import exp, sqrt

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
from microgripper_control.validation.effects.kinds import ELASTO_PLASTIC, MAXWELL_SLIP

SLIDERS = 8
BRISTLE_DAMPING = 0.3  # over sqrt(stiffness m)
SLOW = 0.5  # strokes a second, Stribeck's velocity
STRIDE = 0.1  # of the limit
FORGOTTEN = 10.0  # limits, after which z is at the limit whatever it was


@compiled
def yielded(part: float, elastic: float) -> float:
    """How much of a motion the bristle does not follow, at z = `part` of the limit ahead of it."""
    if part <= elastic:
        return 0.0
    if part >= 1.0:
        return part
    on = (part - elastic) / (1.0 - elastic)
    return part * on * on * (3.0 - 2.0 * on)


@compiled
def elasto_plastic(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: force in N, excess, slow in m/s, stiffness in N/m, damping in N s/m, elastic.

    state: carried, z. z moves along the way, not in time: by the midpoint rule, in strides.
    """
    way = x1 - x0
    limit = p[0] * (1.0 + p[1] * exp(-((way / step / p[2]) ** 2))) / p[3]
    aim = limit if way > 0.0 else -limit
    z = old[1] if abs(way) < FORGOTTEN * limit else aim
    strides = 1 + int(min(abs(way) / limit, FORGOTTEN) / STRIDE)
    part = way / strides
    for _ in range(strides):
        middle = z + 0.5 * part * (1.0 - yielded(z / aim, p[5]))
        z += part * (1.0 - yielded(middle / aim, p[5]))
    new[0], new[1] = 0.0, z
    return float(-(p[3] * z + p[4] * (z - old[1]) / step))


@compiled
def maxwell_slip(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: number of sliders, then stiffness and largest deflection of each; state: deflections."""
    force = 0.0
    new[0] = 0.0
    for i in range(int(p[0])):
        limit = p[2 + 2 * i]
        new[1 + i] = min(max(old[1 + i] + x1 - x0, -limit), limit)
        force -= p[1 + 2 * i] * new[1 + i]
    return force


def stribeck_bristle(share: float, given: Shape, around: Surroundings) -> Force:
    """Form a."""
    scale = around.scale
    force = share * scale.force
    stiffness = force / (given["presliding"] * scale.stroke)
    damping = BRISTLE_DAMPING * sqrt(stiffness * scale.base.m)
    numbers = [force, given["excess"], SLOW * scale.stroke, stiffness, damping, given["elastic"]]
    return Force(ELASTO_PLASTIC, np.array(numbers))


def sliders(share: float, given: Shape, around: Surroundings) -> Force:
    """Form b: equal forces, deflections spread evenly in their logarithm over a factor of ten."""
    scale = around.scale
    limits = given["presliding"] * scale.stroke * np.geomspace(10**-0.5, 10**0.5, SLIDERS)
    stiffness = share * scale.force / SLIDERS / limits
    pairs = np.column_stack([stiffness, limits]).ravel()
    return Force(MAXWELL_SLIP, np.concatenate([[float(SLIDERS)], pairs]))


EFFECT = Effect(
    "friction",
    "mechanics",
    True,
    (
        Form(
            "a",
            "elasto-plastic bristle with Stribeck's curve",
            strength("1", 0.005, 0.1, "sliding force over the actuator's"),
            (
                shape("presliding", "1", 0.02, 0.05, "deflection before it slides, of the stroke"),
                shape("excess", "1", 0.1, 0.5, "of the force at rest over the sliding one"),
                shape("elastic", "1", 0.3, 0.7, "deflection without any slip, of the limit"),
            ),
            stribeck_bristle,
        ),
        Form(
            "b",
            "Maxwell slip, eight sliders",
            strength("1", 0.005, 0.1, "sliding force over the actuator's"),
            (
                shape(
                    "presliding", "1", 0.02, 0.05, "middle deflection before sliding, of the stroke"
                ),
            ),
            sliders,
        ),
    ),
)
