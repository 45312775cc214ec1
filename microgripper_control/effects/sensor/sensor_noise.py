"""White Gaussian noise of the sensor.

    y[k] = x[k] + std n[k],        n standard normal, independent from sample to sample

The k-th number is a function of the seed and of k alone (splitmix64 of a counter, then Box-Muller),
so streaming and batch agree to the bit and a run can be repeated from its seed.
"""

import math

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Stage, Values

LARGEST_SEED = 2**31 - 1


@compiled
def _uniform(seed: float, counter: float) -> float:
    """splitmix64 of (seed, counter), mapped into (0, 1)."""
    z = np.uint64(seed) * np.uint64(0xD1342543DE82EF95) + np.uint64(counter) * np.uint64(
        0x9E3779B97F4A7C15
    )
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return (float(z >> np.uint64(11)) + 0.5) / 9007199254740992.0


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: how many numbers were drawn so far."""
    std, seed = coefficients[0, 0], coefficients[0, 1]
    count = state[0]
    for j in range(bus.shape[1]):
        radius = math.sqrt(-2.0 * math.log(_uniform(seed, 2.0 * count + 1.0)))
        bus[POSITION, j] += std * radius * math.cos(math.tau * _uniform(seed, 2.0 * count + 2.0))
        count += 1.0
    state[0] = count


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: noise has none."""
    return Prepared(np.array([[values["std"], values["seed"]]]), np.zeros(1), timing.ramped)


LINK = Link(
    name="sensor_noise",
    stage=Stage.SENSOR,
    order=80,
    title="sensor noise",
    source="splitmix64: Steele, Lea, Flood 2014; Box and Muller 1958",
    sampled=True,
    random=True,
    parameters=(
        Parameter(
            "std", "m", 15e-9, 0.0, 1e-2, "standard deviation of one reading", 0.0, fitted=False
        ),
        Parameter(
            "seed",
            "1",
            0.0,
            0.0,
            float(LARGEST_SEED),
            "seed of the random numbers, a whole number",
            fitted=False,
        ),
    ),
    prepare=prepare,
    kernel=kernel,
)
