"""Bouc-Wen in the restoring force, driven by the displacement.

    F = -z,    z' = alpha x' - beta |x'| z |z|^(n-1) - gamma x' |z|^n

The same family as the material's (effects/material/bouc_wen.py) with the displacement in place of
the voltage: a joint, a bond or a bearing whose force remembers the way. The public Bouc-Wen
benchmark is this with alpha 5e4 N/m, beta 800 /m, gamma -1100 /m, n 1.
"""

from collections.abc import Sequence

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent, quantity
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values
from microgripper_control.effects.material.bouc_wen import advance


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    z = advance(before[0], x1 - x0, c[0], c[1], c[2], c[3])
    after[0] = z
    return -z


def coefficients(values: Values) -> Sequence[float]:
    return values["alpha"], values["beta"], values["gamma"], values["n"]


def stiffness(values: Values) -> float:
    return values["alpha"]


RATE_UNIT = "1/(m*N^(n-1))"


def starts(scales: Scales) -> Sequence[Values]:
    """A fiftieth of the stiffness, forgotten over more or less of the stroke, both ways."""
    return [
        {"alpha": 0.02 * scales.stiffness, "beta": beta, "gamma": share * beta}
        for beta in (1.0 / scales.stroke, 4.0 / scales.stroke, 16.0 / scales.stroke)
        for share in (-0.6, 0.0, 0.6)
    ]


def says(values: Values, scales: Scales) -> str:
    decay = max(abs(values["beta"] + values["gamma"]), abs(values["beta"] - values["gamma"]))
    share = percent(values["alpha"] / scales.stiffness)
    text = f"the restoring force has hysteresis: after each reversal it is {share} stiffer"
    if decay == 0.0 or values["alpha"] == 0.0:
        return text
    forgotten = (values["alpha"] / decay) ** (1.0 / values["n"]) / values["alpha"]
    return f"{text}, until the finger has moved about {quantity(forgotten, 'm')}"


LINK = Link(
    name="restoring_force_hysteresis",
    stage=Stage.MECHANICS,
    order=40,
    title="hysteresis in the restoring force",
    source="Bouc 1967, Wen 1976; Noel and Schoukens 2016, doi 10.4121/12967592",
    force=Force(law, coefficients, stiffness, states=1),
    parameters=(
        Parameter("alpha", "N/m", 2e6, 0.0, 1e12, "stiffness of z after a reversal", 0.0),
        Parameter("beta", RATE_UNIT, 1e5, -1e12, 1e12, "decay of z with travel, both ways"),
        Parameter("gamma", RATE_UNIT, 2e4, -1e12, 1e12, "decay of z by direction"),
        Parameter("n", "1", 1.0, 1.0, 5.0, "sharpness of the bend", fitted=False),
    ),
    starts=starts,
    says=says,
)
