"""Never in a library: an interferometer's cyclic error.

Mixed polarisations add a sine with the period of half a wavelength of the light, and one of half of
that (Hou and Wilkening, Precision Engineering 14, 1992). Strength: its amplitude, in m.
"""

from __future__ import annotations

from math import pi

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

SECOND = 0.4  # of the doubled frequency over the first


def interferometer(size: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    period = given["half_wavelength"]

    def run(block: Block) -> None:
        turn = 2.0 * pi * (block.signal / period + given["phase"])
        block.signal += size * (np.sin(turn) + SECOND * np.sin(2.0 * turn))

    return Element(Slot.READING, run)


EFFECT = Effect(
    "cyclic_error",
    "sensor",
    False,
    (
        Form(
            "b",
            "an interferometer's cyclic error",
            strength("m", 2.5e-8, 1e-5, "amplitude"),
            (
                shape("half_wavelength", "m", 2.5e-7, 7.8e-7, "period of the error"),
                shape("phase", "1", 0.0, 1.0, "of the error at zero, in periods"),
            ),
            interferometer,
            repeatable=False,
        ),
    ),
)
