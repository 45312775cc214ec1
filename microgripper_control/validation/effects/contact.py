"""An object or stop beyond a position.

a: Hertz's law with dissipation (Hunt and Crossley, J. Appl. Mech. 42, 1975), never pulling, between
   rough surfaces, whose highest asperities touch first, exponentially many with the approach
   (Greenwood and Williamson, Proc. R. Soc. A 295, 1966):
       F = -stiffness depth^1.5 (1 + loss x'),   depth = rough ln(1 + exp((x - position) / rough))
b: a sticky, slowly yielding object: a spring with a Maxwell branch beside it (standard linear
   solid), which on the way back holds on by adhesion until it is stretched by a tenth of its way
   (pull-off as in Johnson, Kendall and Roberts, Proc. R. Soc. A 324, 1971).
Strength: the force when pressed to full stroke, over what would hold the actuator back by its whole
stroke.
"""

from __future__ import annotations

from math import exp, log1p

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
from microgripper_control.validation.effects.kinds import HERTZ, STICKY

STRONGEST_LOSS = 1.0  # loss times velocity, so that an impact at most doubles the force
NO_ASPERITY = 40.0  # roughnesses before the position: nothing touches
STRETCH = 0.1  # of the way from first touch to full stroke, at which adhesion gives way


@compiled
def hunt_crossley(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: stiffness in N/m^1.5, position in m, loss in s/m, roughness in m."""
    near = (x1 - p[1]) / p[3]
    if near <= -NO_ASPERITY:
        return 0.0
    depth = p[3] * (max(near, 0.0) + log1p(exp(-abs(near))))
    loss = min(max(p[2] * v1, -STRONGEST_LOSS), STRONGEST_LOSS)
    return float(-p[0] * depth**1.5 * (1.0 + loss))


@compiled
def sticky_object(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: stiffness, position, stretch in m, branch's stiffness, its decay in a step.

    state: carried, touching (1 or 0), force of the branch, depth before.
    """
    depth = x1 - p[1]
    held = (old[1] == 1.0 and depth > -p[2]) or depth > 0.0
    new[0] = 0.0
    if not held:
        new[1], new[2], new[3] = 0.0, 0.0, 0.0
        return 0.0
    before = old[3] if old[1] == 1.0 else 0.0
    new[1] = 1.0
    new[2] = p[4] * old[2] + p[3] * (depth - before)
    new[3] = depth
    return float(-(p[0] * depth + new[2]))


def hertzian(press: float, given: Shape, around: Surroundings) -> Force:
    """Form a."""
    scale = around.scale
    position = scale.displacement(given["position"])
    stiffness = press * scale.force / (scale.top - position) ** 1.5
    loss = given["loss"] / (0.01 * scale.stroke * scale.base.natural_frequency)
    rough = given["roughness"] * scale.stroke
    return Force(HERTZ, np.array([stiffness, position, loss, rough]))


def sticky(press: float, given: Shape, around: Surroundings) -> Force:
    """Form b."""
    scale = around.scale
    position = scale.displacement(given["position"])
    way = scale.top - position
    stiffness = press * scale.force / way
    decay = exp(-around.step / given["yield_time"])
    numbers = [stiffness, position, STRETCH * way, given["branch"] * stiffness, decay]
    return Force(STICKY, np.array(numbers))


def beyond_touch(press: float, given: Shape, reach: Reach) -> list[Place]:
    """From first touch on."""
    low, high = reach.scale.displacement(given["position"]), reach.displacement[1]
    return [Place("displacement_m", low, high)] if low < high else []


EFFECT = Effect(
    "contact",
    "mechanics",
    True,
    (
        Form(
            "a",
            "Hertzian, of rough surfaces, with Hunt and Crossley's loss",
            strength("1", 0.05, 2.0, "force at full stroke over the actuator's"),
            (
                shape("position", "1", 0.5, 0.8, "of first touch, share of the stroke"),
                shape("loss", "1", 0.1, 0.5, "at a hundredth of stroke times natural frequency"),
                shape("roughness", "1", 0.01, 0.03, "of the surfaces, of the stroke"),
            ),
            hertzian,
            beyond_touch,
        ),
        Form(
            "b",
            "a sticky object that yields slowly",
            strength("1", 0.05, 1.0, "lasting force at full stroke over the actuator's"),
            (
                shape("position", "1", 0.5, 0.8, "of first touch, share of the stroke"),
                shape("branch", "1", 0.2, 0.6, "stiffness that yields over that which lasts"),
                shape("yield_time", "s", 0.2, 2.0, "in which the branch yields"),
            ),
            sticky,
            beyond_touch,
        ),
    ),
)
