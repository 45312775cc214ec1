"""Play between actuator and finger.

    x_f = min(max(x_f before, x - play / 2), x + play / 2)

The finger rests until one flank of the gap reaches it, then moves with that flank: the play
operator, which depends on the course of x and not on its speed. It starts in the middle of the gap.
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
    """State: position of the finger."""
    half = coefficients[0, 0]
    finger = state[0]
    for j in range(bus.shape[1]):
        x = bus[POSITION, j]
        finger = min(max(finger, x - half), x + half)
        bus[POSITION, j] = finger
    state[0] = finger


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: a finger in the middle of the gap stands at x."""
    return Prepared(np.array([[values["play"] / 2.0]]), np.array([levels[POSITION]]), timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Small and large shares of the stroke."""
    return [{"play": share * scales.stroke} for share in (0.002, 0.01, 0.04)]


def says(values: Values, scales: Scales) -> str:
    return f"there is play between actuator and finger: {quantity(values['play'], 'm')}"


LINK = Link(
    name="backlash",
    stage=Stage.TRANSMISSION,
    order=0,
    title="play between actuator and finger",
    source="play operator: Krasnosel'skii and Pokrovskii 1989; Tao and Kokotovic 1996",
    parameters=(Parameter("play", "m", 2e-7, 0.0, 1e-2, "width of the gap", 0.0),),
    prepare=prepare,
    kernel=kernel,
    follows=True,
    starts=starts,
    says=says,
)
