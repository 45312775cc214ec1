"""The amplifier's output range, hard or soft.

    u_s = u + r(low - u) - r(u - high),        r(e) = softness ln(1 + exp(e / softness))

At softness 0, r(e) = max(e, 0): the voltage is cut at both levels. With softness the bend is spread
over a few times as many volts around each. The levels are out of reach where the effect vanishes.
The link stands before slew limit and lag, which act on what the output stage is able to put out.
"""

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

OUT_OF_REACH = 1e4  # V
SOFT = 0.02  # of the swing: softer bends are called so


@compiled
def _excess(e: float, softness: float) -> float:
    """r(e), V; exact at softness 0 and without overflow far from the bend."""
    if softness == 0.0 or abs(e) > 40.0 * softness:
        return max(e, 0.0)
    return max(e, 0.0) + softness * math.log1p(math.exp(-abs(e) / softness))


@compiled
def limited(u: float, low: float, high: float, softness: float) -> float:
    """What the output stage makes of a command, V."""
    return u + _excess(low - u, softness) - _excess(u - high, softness)


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    low, high, softness = coefficients[0, 0], coefficients[0, 1], coefficients[0, 2]
    for j in range(bus.shape[1]):
        bus[VOLTAGE, j] = limited(bus[VOLTAGE, j], low, high, softness)


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """No state, and no memory: a held signal stays one."""
    row = (values["low"], values["high"], values["softness"])
    levels[VOLTAGE] = limited(levels[VOLTAGE], *row)
    return Prepared(np.array([row]), np.zeros(0), timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Each end of the range cut, and both, a little and much, hard and soft."""
    (low, high), swing = scales.voltage, scales.swing
    off = {"low": -OUT_OF_REACH, "high": OUT_OF_REACH}
    found = []
    for cut in (0.0, 0.05, 0.15, 0.35):
        ends = {"low": low + cut * swing, "high": high - cut * swing}
        for levels in ({"low": ends["low"]}, {"high": ends["high"]}, ends):
            found += [off | levels | {"softness": soft * swing} for soft in (0.01, 0.05)]
    return found


def says(values: Values, scales: Scales) -> str:
    bends = 3.0 * values["softness"]
    ends = []
    if values["high"] < scales.voltage[1] + bends:
        ends.append(f"above {quantity(values['high'], 'V', 3)}")
    if values["low"] > scales.voltage[0] - bends:
        ends.append(f"below {quantity(values['low'], 'V', 3)}")
    soft = "softly " if values["softness"] > SOFT * scales.swing else ""
    return f"the amplifier saturates {soft}{' and '.join(ends) or 'just beyond the range in use'}"


LINK = Link(
    name="saturation",
    stage=Stage.DRIVE,
    order=20,
    title="output range of the amplifier",
    source="definition of a clipper; softplus: Dugas et al. 2001",
    parameters=(
        Parameter("low", "V", -20.0, -OUT_OF_REACH, OUT_OF_REACH, "lowest output", -OUT_OF_REACH),
        Parameter("high", "V", 150.0, -OUT_OF_REACH, OUT_OF_REACH, "highest output", OUT_OF_REACH),
        Parameter("softness", "V", 1.0, 0.0, 100.0, "width of the bends, 0 if hard"),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    says=says,
)
