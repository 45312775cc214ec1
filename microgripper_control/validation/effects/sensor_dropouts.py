"""Never in a library: the sensor now and then holds an old reading, or jumps for one sample.

Strength: events a second. Each is a dropout of some tens of milliseconds or, one time in three, a
spike of up to a twentieth of the stroke. More strength adds events and keeps the others.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
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

MOST = 20.0  # events a second
SPIKE = 0.05  # of the stroke


@compiled
def march_failures(stale: Array, spikes: Array, state: Array, first: int, readings: Array) -> None:
    """`stale` and `spikes` (m) for each sample of the recording; state: reading before."""
    for j in range(len(readings)):
        k = first + j
        if k < 0 or stale[k] == 0.0:
            state[0] = readings[j]
        readings[j] = state[0] + (spikes[k] if k >= 0 else 0.0)


def failing_sensor(often: float, given: Shape, around: Surroundings) -> Element:
    """The only form."""
    generator = around.generator()
    count = generator.poisson(MOST * around.duration)
    begins = generator.uniform(0.0, around.duration, count)
    ranks = generator.uniform(0.0, MOST, count)
    jumps = generator.uniform(-SPIKE, SPIKE, count) * around.scale.stroke
    lasting = generator.exponential(given["lasting"], count)
    kinds = generator.uniform(0.0, 3.0, count)
    samples = round(around.duration / around.sample_period) + 1
    stale, spikes, state = np.zeros(samples), np.zeros(samples), np.zeros(1)
    for i in np.flatnonzero(ranks < often):
        k = int(begins[i] / around.sample_period)
        if kinds[i] < 1.0:
            spikes[k] = jumps[i]
        else:
            stale[k : k + 1 + int(lasting[i] / around.sample_period)] = 1.0

    def run(block: Block) -> None:
        first = round(block.time / around.sample_period) + 1
        march_failures(stale, spikes, state, first, block.signal)

    return Element(Slot.CONVERTER, run)


EFFECT = Effect(
    "sensor_dropouts",
    "sensor",
    False,
    (
        Form(
            "b",
            "stale readings and spikes",
            strength("1/s", 0.1, MOST, "events"),
            (shape("lasting", "s", 0.02, 0.08, "mean length of a dropout"),),
            failing_sensor,
            repeatable=False,
        ),
    ),
)
