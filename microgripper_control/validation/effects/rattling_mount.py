"""Never in a library: the sensor's mount is loose and rattles between two stops.

The floor's vibration throws it about; it loses half of its speed at each stop and rubs in between:

    z'' = shaking n(t) - rub z',   |z| <= gap / 2

with n slow noise of unit variance. Strength: the gap over the stroke.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.chance import slow_course
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

RESTITUTION = 0.5
SHAKING_CORNER = 12.0  # Hz
CROSSING = 0.03  # s, in which the shaking carries the mount across its gap
RUB = 30.0  # 1/s


@compiled
def march_rattle(p: Array, state: Array, shaking: Array, position: Array) -> None:
    """p: half gap in m, rub, step; state: z, z'; shaking in m/s^2."""
    z, w = state[0], state[1]
    for j in range(len(position)):
        w += p[2] * (shaking[j] - p[1] * w)
        z += p[2] * w
        if abs(z) > p[0]:
            z = p[0] if z > 0.0 else -p[0]
            if w * z > 0.0:
                w *= -RESTITUTION
        position[j] += z
    state[0], state[1] = z, w


def loose_mount(gap: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    half = 0.5 * gap * around.scale.stroke
    course = slow_course(around.generator(), -around.past, around.duration, SHAKING_CORNER)
    size = given["shaking"] * 4.0 * half / CROSSING**2
    numbers = np.array([half, RUB, around.step])
    state = np.zeros(2)

    def run(block: Block) -> None:
        march_rattle(numbers, state, size * course(block.times), block.signal)

    return Element(Slot.POSITION, run)


EFFECT = Effect(
    "rattling_mount",
    "sensor",
    False,
    (
        Form(
            "a",
            "a loose mount between two stops",
            strength("1", 0.003, 0.1, "gap over the stroke"),
            (shape("shaking", "1", 0.5, 2.0, "of what crosses the gap in 30 ms"),),
            loose_mount,
            repeatable=False,
        ),
    ),
)
