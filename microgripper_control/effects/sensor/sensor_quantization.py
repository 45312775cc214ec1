"""Finite resolution of the sensor or its converter.

y = resolution * round(x / resolution)
"""

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    resolution = coefficients[0, 0]
    for j in range(bus.shape[1]):
        bus[POSITION, j] = resolution * np.rint(bus[POSITION, j] / resolution)


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """No state."""
    return Prepared(np.array([[values["resolution"]]]), np.zeros(0), timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """The grid that the readings lie on, if they do."""
    return [{"resolution": scales.resolution}] if scales.resolution > 0.0 else []


def says(values: Values, scales: Scales) -> str:
    return f"the sensor is coarse: it shows steps of {quantity(values['resolution'], 'm')}"


LINK = Link(
    name="sensor_quantization",
    stage=Stage.SENSOR,
    order=90,
    title="finite resolution of the sensor",
    source="definition of a mid-tread quantiser; the paper's sensor: 1 um",
    sampled=True,
    parameters=(
        Parameter(
            "resolution", "m", 1e-6, 0.0, 1e-2, "smallest step the sensor shows", 0.0, fitted=False
        ),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    says=says,
)
