"""Never in a library: the sensor's gain waves over its range.

Strength: the amplitude, over the stroke, of a Chebyshev polynomial of fifth or so degree, which has
next to nothing in common with a straight line, a square or a cube.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.validation.block import Block
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


def waving_gain(amount: float, given: Shape, around: Surroundings) -> Element:
    """The only form: cos(degree acos z), for a degree that need not be whole."""
    scale = around.scale
    middle = scale.displacement(0.5)

    def run(block: Block) -> None:
        z = np.clip((block.signal - middle) / (0.55 * scale.stroke), -1.0, 1.0)
        block.signal += amount * scale.stroke * np.cos(given["degree"] * np.arccos(z))

    return Element(Slot.READING, run)


EFFECT = Effect(
    "sensor_polynomial",
    "sensor",
    False,
    (
        Form(
            "a",
            "a gain that waves over the range",
            strength("1", 0.003, 0.1, "amplitude over the stroke"),
            (shape("degree", "1", 5.0, 7.0, "of the polynomial"),),
            waving_gain,
        ),
    ),
)
