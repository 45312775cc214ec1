"""Stiffness of flexure and stack that changes with displacement.

    F = -quadratic x^2 - cubic x^3 / (1 + levelling x^2)         levelling >= 0
    F = -quadratic x^2 - cubic x^3 (1 - levelling x^2)           levelling < 0

The next two terms of the restoring force after (k + k_s) x: the quadratic one for a flexure that is
not symmetric about x = 0, the cubic one for stretching (positive, it stiffens) or buckling
(negative, it softens). A leaf that is stretched far pulls like a string in the end: the cubic term
levels off to a straight one. Where levelling is negative it steepens instead.
"""

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values

BOTH = 0.25  # of the larger change of stiffness: a smaller one the other way is told as well


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    square = x1 * x1
    cubic = c[1] * x1 / (1.0 + c[2] * square) if c[2] > 0.0 else c[1] * x1 * (1.0 - c[2] * square)
    force: float = -(c[0] + cubic) * square
    return force


def coefficients(values: Values) -> Sequence[float]:
    return values["quadratic"], values["cubic"], values["levelling"]


def stiffness(values: Values) -> float:
    """Counted with that of the mass: beyond a few times it, the solve gets less accurate."""
    return 0.0


def starts(scales: Scales) -> Sequence[Values]:
    """Each term by itself, a twentieth of the stiffness over the stroke; a strong one that levels.

    Far from straight, the plant without it is no guide: the strong ones begin at the nominal one.
    """
    k, stroke = scales.stiffness, scales.stroke
    cubic = {"quadratic": 0.0, "cubic": k / stroke**2, "levelling": 0.0}
    return [
        {"quadratic": 0.05 * k / stroke, "cubic": 0.0, "levelling": 0.0},
        {**cubic, "cubic": 0.05 * cubic["cubic"]},
        *(
            {**cubic, "cubic": share * cubic["cubic"], "levelling": 1.5 / stroke**2}
            for share in (0.3, 1.0, 3.0)
        ),
    ]


def says(values: Values, scales: Scales) -> str:
    c, none = np.array(coefficients(values)), np.zeros(0)
    x = np.linspace(*scales.position, 501)
    force = np.array([-law(c, none, none, at, at, 0.0, 0.0) for at in x])
    change = np.gradient(force, x, edge_order=2) / scales.stiffness
    change -= change[int(np.argmin(np.abs(x)))]
    softer, stiffer = -float(change.min()), float(change.max())  # than at rest; neither below 0
    if min(softer, stiffer) > BOTH * max(softer, stiffer):
        return (
            f"the flexure stiffens by {percent(stiffer)} in one part of the stroke and softens by "
            f"{percent(softer)} in another"
        )
    way = "stiffens" if stiffer >= softer else "softens"
    return f"the flexure {way} by {percent(max(softer, stiffer))} over the stroke"


LINK = Link(
    name="nonlinear_stiffness",
    stage=Stage.MECHANICS,
    order=10,
    title="stiffness that changes with displacement",
    source="Duffing 1918; for flexures Howell 2001, chapter 2",
    force=Force(law, coefficients, stiffness),
    parameters=(
        Parameter(
            "quadratic",
            "N/m^2",
            5e10,
            -1e20,
            1e20,
            "coefficient of x^2 in the restoring force",
            0.0,
        ),
        Parameter(
            "cubic", "N/m^3", 2.5e15, -1e26, 1e26, "coefficient of x^3 in the restoring force", 0.0
        ),
        Parameter(
            "levelling",
            "1/m^2",
            0.0,
            -4e12,
            4e12,
            "how the cubic term levels off; below 0 it steepens",
        ),
    ),
    starts=starts,
    says=says,
)
