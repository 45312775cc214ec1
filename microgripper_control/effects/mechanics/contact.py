"""An object or stop that pushes back beyond a position.

    F = -side stiffness r (depth / r)^exponent min(max(0, 1 + damping depth'), 5/2),
    depth = max(0, side (x - position)),        r = 1 um

Exponent 1 is a linear spring, 3/2 two curved bodies (Hertz); r is where `stiffness` is force by
depth, so that its unit does not depend on the exponent. The damping of Hunt and Crossley grows with
the depth: the force is continuous at the touch and never pulls. Theirs is 3/2 (1 - restitution)
over the speed of the impact, so the force is never more than 5/2 of that at rest; nor is it here,
however fast a step of the voltage throws the mass.
"""

from collections.abc import Mapping, Sequence

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import number, quantity
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Force, Link, Scales, Stage, Values

REFERENCE = 1e-6  # m, r above
BESIDE = 0.1  # of the stroke: what the nominal model may be wrong about where it ends
HARDEST = 2.5  # times the force at rest: the beginning of an impact from which nothing springs back


def law(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    side = c[4]
    depth = side * (x1 - c[0])
    if depth <= 0.0:
        return 0.0
    shape = 1.0 if c[2] == 1.0 else (depth / REFERENCE) ** (c[2] - 1.0)
    grip = min(max(0.0, 1.0 + c[3] * side * v), HARDEST)
    force: float = -side * c[1] * depth * shape * grip
    return force


def coefficients(values: Values) -> Sequence[float]:
    side = 1.0 if values["side"] >= 0.0 else -1.0
    return values["position"], values["stiffness"], values["exponent"], values["damping"], side


def stiffness(values: Values) -> float:
    return values["exponent"] * values["stiffness"]


def starts(scales: Scales) -> Sequence[Values]:
    """An object met in the upper or lower part of the stroke, as stiff as a tenth of the rig."""
    return [
        {
            "position": scales.position[0] + share * scales.stroke,
            "stiffness": 0.1 * scales.stiffness,
            "exponent": exponent,
            "side": side,
        }
        for side, shares in ((1.0, (0.2, 0.4, 0.6, 0.75, 0.9)), (-1.0, (0.1, 0.25, 0.4, 0.6)))
        for share in shares
        for exponent in (1.0, 1.5)
    ]


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """What is touched all the time is a spring of the rig; what is never touched is not there.

    A stop that is a hundred times stiffer than the rig is just hard: no recording tells more.
    """
    low, high = scales.position
    beside = BESIDE * scales.stroke
    return {
        "position": (low - beside, high + beside),
        "stiffness": (0.0, 100.0 * scales.stiffness),
    }


def says(values: Values, scales: Scales) -> str:
    way = "beyond" if values["side"] >= 0.0 else "below"
    where, push = quantity(values["position"], "m", 3), number(1e-6 * values["stiffness"])
    depth = "for each µm" if values["exponent"] == 1.0 else "at 1 µm of depth"
    return f"the finger meets something: {way} x = {where} it is pushed back, by {push} N {depth}"


LINK = Link(
    name="contact",
    stage=Stage.MECHANICS,
    order=20,
    title="contact with an object or stop",
    source="Hertz 1881; Hunt and Crossley 1975",
    force=Force(law, coefficients, stiffness, brakes=True),
    parameters=(
        Parameter("position", "m", 1.5e-5, -1.0, 1.0, "where the finger touches"),
        Parameter("stiffness", "N/m", 2e6, 0.0, 1e12, "force by depth, 1 um deep", 0.0),
        Parameter("exponent", "1", 1.0, 1.0, 3.0, "1 linear, 1.5 Hertz", fitted=False),
        Parameter("damping", "s/m", 0.0, 0.0, 1e6, "share of force by speed"),
        Parameter("side", "1", 1.0, -1.0, 1.0, "1 beyond, -1 below the position", fitted=False),
    ),
    starts=starts,
    plausible=plausible,
    says=says,
)
