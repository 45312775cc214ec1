"""The amplifier's output range, hard or soft.

    u_s = u + r(low - u) - r(u - high),        r(e) = softness ln(1 + exp(e / softness))

At softness 0, r(e) = max(e, 0): the voltage is cut at a level. With softness the bend is spread
over a few times as many volts around it. Each level has its own: what pulls the output up is not
what pulls it down. The levels are out of reach where the effect vanishes.
The link stands before slew limit and lag, which act on what the output stage is able to put out.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import PLACES, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

OUT_OF_REACH = 1e4  # V
SOFT = 0.02  # of the swing: softer bends are called so
WIDEST = 0.15  # of the swing: the softest bend, which takes two thirds of it
FELT = 3.0  # softnesses: a level further beyond the range in use does next to nothing


@compiled
def _excess(e: float, softness: float) -> float:
    """r(e), V; exact at softness 0 and without overflow far from the bend."""
    if softness == 0.0 or abs(e) > 40.0 * softness:
        return max(e, 0.0)
    return max(e, 0.0) + softness * math.log1p(math.exp(-abs(e) / softness))


@compiled
def limited(u: float, low: float, high: float, low_softness: float, high_softness: float) -> float:
    """What the output stage makes of a command, V."""
    return u + _excess(low - u, low_softness) - _excess(u - high, high_softness)


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    c = coefficients[0]
    for j in range(bus.shape[1]):
        bus[VOLTAGE, j] = limited(bus[VOLTAGE, j], c[0], c[1], c[2], c[3])


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """No state, and no memory: a held signal stays one."""
    row = [values[name] for name in ("low", "high", "low_softness", "high_softness")]
    for place in PLACES:
        levels[place + VOLTAGE] = limited(levels[place + VOLTAGE], *row)
    return Prepared(np.array([row]), np.zeros(0), timing.ramped)


def nonsense(values: Values) -> str:
    low, high = values["low"], values["high"]
    return "" if low < high else f"low {low:g} V must be below high {high:g} V"


def starts(scales: Scales) -> Sequence[Values]:
    """Each end of the range cut, and both, a little and much, hard and soft.

    An end that is not cut stands where it is just felt: out of reach, no fit would find it.
    """
    (low, high), swing = scales.voltage, scales.swing
    found = []
    for cut in (0.0, 0.05, 0.15, 0.35):
        for soft in (0.01 * swing, 0.05 * swing):
            inside, beside = cut * swing, -FELT * soft
            for at_low, at_high in ((inside, beside), (beside, inside), (inside, inside)):
                ends = {"low": low + at_low, "high": high - at_high}
                found.append(ends | {"low_softness": soft, "high_softness": soft})
    return found


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A bend over most of the swing is a gain that falls off, and no end of a range."""
    softness = (0.0, WIDEST * scales.swing)
    return {"low_softness": softness, "high_softness": softness}


def says(values: Values, scales: Scales) -> str:
    ends, softest = [], 0.0
    for name, word, over in (
        ("high", "above", scales.voltage[1] - values["high"]),
        ("low", "below", values["low"] - scales.voltage[0]),
    ):
        softness = values[f"{name}_softness"]
        if over > -FELT * softness:
            ends.append(f"{word} {quantity(values[name], 'V', 3)}")
            softest = max(softest, softness)
    soft = "softly " if softest > SOFT * scales.swing else ""
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
        Parameter(
            "low_softness", "V", 1.0, 0.0, 100.0, "width of the bend at the lowest, 0 if hard"
        ),
        Parameter(
            "high_softness", "V", 1.0, 0.0, 100.0, "width of the bend at the highest, 0 if hard"
        ),
    ),
    prepare=prepare,
    kernel=kernel,
    nonsense=nonsense,
    starts=starts,
    plausible=plausible,
    says=says,
)
