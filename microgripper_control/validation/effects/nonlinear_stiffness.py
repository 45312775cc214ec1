"""A flexure whose stiffness changes with displacement.

a: hardening by tension: a leaf held at both ends is stretched by its own deflection, like a spring
   across the motion that is slack at rest (Howell, Compliant Mechanisms, 2001):
       F = -strength K x (1 - 1 / sqrt(1 + (x / length)^2))
b: softening by release: part of the preload lets go around a displacement, over a wide range:
       dF/dx = strength K (1 + tanh((x - middle) / width)) / 2
K is the stiffness of stack and flexure.
"""

from __future__ import annotations

from math import exp, log1p, sqrt

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array
from microgripper_control.validation.effects.form import (
    Effect,
    Force,
    Form,
    Place,
    Reach,
    Shape,
    Surroundings,
    shape,
    strength,
)
from microgripper_control.validation.effects.kinds import RELEASE, TENSION


@compiled
def tension(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: strength K in N/m, length in m."""
    return float(-p[0] * x1 * (1.0 - 1.0 / sqrt(1.0 + (x1 / p[1]) ** 2)))


@compiled
def softplus(z: float) -> float:
    """ln(1 + exp(2 z)) / 2 without overflow: the integral of (1 + tanh) / 2."""
    return max(z, 0.0) + 0.5 * log1p(exp(-2.0 * abs(z)))


@compiled
def release(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: strength K in N/m, middle, width in m; no force at x = 0."""
    at_rest = softplus(-p[1] / p[2])
    return float(p[0] * p[2] * (softplus((x1 - p[1]) / p[2]) - at_rest))


def stretching_leaf(share: float, given: Shape, around: Surroundings) -> Force:
    """Form a."""
    scale = around.scale
    numbers = np.array([share * scale.base.stiffness, given["length"] * scale.stroke])
    return Force(TENSION, numbers)


def releasing_preload(share: float, given: Shape, around: Surroundings) -> Force:
    """Form b."""
    scale = around.scale
    numbers = np.array(
        [
            share * scale.base.stiffness,
            scale.displacement(given["middle"]),
            given["width"] * scale.stroke,
        ]
    )
    return Force(RELEASE, numbers)


def beyond_middle(share: float, given: Shape, reach: Reach) -> list[Place]:
    """Where the softer part is the larger one."""
    low = reach.scale.displacement(given["middle"])
    high = reach.displacement[1]
    return [Place("displacement_m", low, high)] if low < high else []


EFFECT = Effect(
    "nonlinear_stiffness",
    "mechanics",
    True,
    (
        Form(
            "a",
            "a leaf that its own deflection stretches: hardening",
            strength("1", 0.05, 3.0, "stiffness of the stretched leaf over that of the actuator"),
            (shape("length", "1", 0.5, 1.5, "over which it stretches, of the stroke"),),
            stretching_leaf,
        ),
        Form(
            "b",
            "preload that lets go over a wide range: softening",
            strength("1", 0.05, 0.6, "stiffness lost over that of the actuator"),
            (
                shape("middle", "1", 0.4, 0.7, "of the transition, share of the stroke"),
                shape("width", "1", 0.2, 0.4, "of the transition, of the stroke"),
            ),
            releasing_preload,
            beyond_middle,
        ),
    ),
)
