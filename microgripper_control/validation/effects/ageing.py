"""Never in a library: d falls while the recording runs, as a ceramic loses its polarisation.

    w -> w (1 - strength ln(1 + t / early) / ln(1 + duration / early))

(logarithmic ageing: Jaffe, Cook and Jaffe, Piezoelectric Ceramics, 1971, ch. 5), begun anew by the
heating before each recording.
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


def losing_polarisation(loss: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    early = given["early"]
    whole = np.log1p(around.duration / early)

    def run(block: Block) -> None:
        block.signal *= 1.0 - loss / whole * np.log1p(np.maximum(block.times, 0.0) / early)

    return Element(Slot.FREE, run)


EFFECT = Effect(
    "ageing",
    "material",
    False,
    (
        Form(
            "a",
            "d falls with the logarithm of the time",
            strength("1", 0.01, 0.5, "of d, lost by the end of a recording"),
            (shape("early", "s", 1.0, 10.0, "when the logarithm begins to bend"),),
            losing_polarisation,
        ),
    ),
)
