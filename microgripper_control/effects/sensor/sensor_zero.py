"""The sensor's zero: what it reads when the finger stands at x = 0.

y = x + offset
"""

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Stage, Values


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    for j in range(bus.shape[1]):
        bus[POSITION, j] += coefficients[0, 0]


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """No state."""
    levels[POSITION] += values["offset"]
    return Prepared(np.array([[values["offset"]]]), np.zeros(0), timing.ramped)


LINK = Link(
    name="sensor_zero",
    stage=Stage.SENSOR,
    order=50,
    title="zero of the sensor",
    source="definition",
    sampled=True,
    parameters=(Parameter("offset", "m", 0.0, -1.0, 1.0, "reading at x = 0", 0.0),),
    prepare=prepare,
    kernel=kernel,
)
