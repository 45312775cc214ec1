"""Play between actuator and finger, which may follow the flanks of the gap with a lag.

    T x_f' = dead(x - x_f),        T = slowness play,        dead(e) = e - min(max(e, -h), h)

with h half the play. The finger rests until one flank of the gap reaches it. At slowness 0 it then
moves with that flank: x_f = min(max(x_f before, x - h), x + h), the play operator, which depends on
the course of x and not on its speed. Else a contact with stiffness k pushes a finger that viscous
friction c holds, T = c / k: it trails behind the flank, and comes to rest at it some T after x has.
T is told per play, so that it goes with it: without play this is no lag of a sensor.

A run begins with the finger at the flank that pushed it last, as h remembers; without h, in the
middle of the gap. x is taken as straight between the internal steps, and followed exactly.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import GONE, POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

SHORTEST = 1e-12  # of a step: T that counts as none
SLOWEST = 0.3  # s, T at a play as wide as the stroke
SHOWN = 0.05  # of a sample period: a shorter T is not spoken of


@compiled
def _trail(e: float, way: float, rate: float, half: float) -> float:
    """x - x_f at the end of a step on which x goes `way` >= 0, m, from e before; `rate` is step/T.

    On the way up the finger leaves the lower flank, crosses the gap and meets the upper one.
    """
    left = 1.0
    if e < -half:
        behind = -half - e
        leaves = math.log1p(behind * rate / way) / rate if way > 0.0 else 1.0
        if leaves >= 1.0:
            return e - math.expm1(-rate) * (way / rate + behind)
        e, left = -half, 1.0 - leaves
    if e < half:
        if half - e >= way * left:
            return e + way * left
        e, left = half, left - (half - e) / way
    return e - math.expm1(-rate * left) * (way / rate - (e - half))


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: position of the finger and, if it trails, x so far. A row: half, then step/T."""
    finger = state[0]
    steps = coefficients.shape[0]
    if coefficients.shape[1] == 1:
        half = coefficients[0, 0]
        for j in range(bus.shape[1]):
            x = bus[POSITION, j]
            finger = min(max(finger, x - half), x + half)
            bus[POSITION, j] = finger
    else:
        old, row = state[1], 0
        for j in range(bus.shape[1]):
            c = coefficients[row]
            x = bus[POSITION, j]
            if x >= old:
                finger = x - _trail(old - finger, x - old, c[1], c[0])
            else:
                finger = x + _trail(finger - old, old - x, c[1], c[0])
            old = x
            bus[POSITION, j] = finger
            row = row + 1 if row + 1 < steps else 0
        state[1] = old
    state[0] = finger


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """At rest the finger is where x left it, coming from the side that h remembers."""
    half, level = values["play"] / 2.0, levels[POSITION]
    lag = values["slowness"] * values["play"]
    levels[POSITION] = finger = level - min(max(levels[GONE], -half), half)
    if lag == 0.0:
        return Prepared(np.array([[half]]), np.array([finger]), timing.ramped)
    rows = [(half, step / max(lag, SHORTEST * step)) for step in timing.steps]
    return Prepared(np.array(rows), np.array([finger, level]), timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Small and large shares of the stroke, followed as good as at once or more and more slowly."""
    slowest = SLOWEST / scales.stroke
    return [
        {"play": share * scales.stroke, "slowness": slowness * slowest}
        for share in (0.002, 0.01, 0.04)
        for slowness in (0.001, 0.03, 0.1, 0.3, 1.0)
    ]


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A play that trails longer would be too narrow to show: it would pass for any lag."""
    return {"slowness": (0.0, SLOWEST / scales.stroke)}


def says(values: Values, scales: Scales) -> str:
    text = f"there is play between actuator and finger: {quantity(values['play'], 'm')}"
    lag = values["slowness"] * values["play"]
    if lag < SHOWN * scales.sample_period:
        return text
    return f"{text}, which the finger follows with a time constant of {quantity(lag, 's')}"


LINK = Link(
    name="backlash",
    stage=Stage.TRANSMISSION,
    order=0,
    title="play between actuator and finger",
    source="Krasnosel'skii and Pokrovskii 1989 (play); Nordin, Galic, Gutman 1997 (trailing)",
    parameters=(
        Parameter("play", "m", 2e-7, 0.0, 1e-2, "width of the gap", 0.0),
        Parameter("slowness", "s/m", 0.0, 0.0, 1e6, "time constant of following, per play"),
    ),
    prepare=prepare,
    kernel=kernel,
    follows=True,
    starts=starts,
    plausible=plausible,
    says=says,
)
