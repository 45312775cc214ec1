"""Hysteresis whose rising and falling branches differ by more than beta and gamma give.

    w_a = w - (tilt u + bulge u^2 + twist u^3 + skew s) s,        reach s' = (sgn u' - s) |u'|

s is the direction in which the voltage goes, +-1, as the material remembers it: after a turn it
changes over within a travel of `reach`. Its weight follows the voltage, so the branches part by
`tilt` more towards one end of the range, by `bulge` more in the middle or at both ends, by `twist`
one way in its lower and the other way in its upper part; `skew` moves both branches where they are
far from a turn. Only the way counts, not the speed. A weight without u is left out: that is a loop
as h is one. Generalised Bouc-Wen equations put such terms into h' (Zhu and Wang delta u sgn(u'),
Song and Der Kiureghian the signs of products of u, u' and h); put beside it they leave its closed
form alone.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent
from microgripper_control.core.signals import FREE, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: s and the voltage so far. A row: tilt, bulge, twist, skew, reach."""
    c = coefficients[0]
    s, old = state[0], state[1]
    for j in range(bus.shape[1]):
        u = bus[VOLTAGE, j]
        if u != old:
            kept = math.exp(-abs(u - old) / c[4])
            s = kept * s + (1.0 - kept if u > old else kept - 1.0)
            old = u
        bus[FREE, j] -= (((c[2] * u + c[1]) * u + c[0]) * u + c[3] * s) * s
    state[0], state[1] = s, old


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: a material at rest remembers no direction."""
    row = [values[name] for name in ("tilt", "bulge", "twist", "skew", "reach")]
    return Prepared(np.array([row]), np.array([0.0, levels[VOLTAGE]]), timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Each of the four ways by itself, a hundredth of the stroke, with two memories."""
    u, size = max(abs(volts) for volts in scales.voltage), 0.01 * scales.stroke
    off = {"tilt": 0.0, "bulge": 0.0, "twist": 0.0, "skew": 0.0}
    ways = {"tilt": size / u, "bulge": size / u**2, "twist": size / u**3, "skew": size}
    return [
        off | {name: way, "reach": share * scales.swing}
        for share in (0.08, 0.2)
        for name, way in ways.items()
    ]


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A turn is forgotten within the swing, as the paper's beta has it.

    With a longer reach s would be the voltage itself, and the loop a bent line; with a shorter one
    the branches would jump apart.
    """
    return {"reach": (0.02 * scales.swing, 0.6 * scales.swing)}


def says(values: Values, scales: Scales) -> str:
    share = percent(float(np.max(np.abs(apart(values, scales)))) / scales.stroke)
    return (
        "the hysteresis is lopsided: between rising and falling voltage the branches lie up to "
        f"{share} of the stroke closer together, or further apart, than the model's"
    )


def apart(values: Values, scales: Scales) -> Array:
    """How much further than the paper's the branches of the largest loop are apart, m, (50,).

    At voltages evenly over it.
    """
    u = np.linspace(*scales.voltage, 50)
    reach, low, high = values["reach"], u[0], u[-1]
    turned = 1.0 + math.tanh((high - low) / (2.0 * reach))
    rising, falling = 1.0 - turned * np.exp((low - u) / reach), turned * np.exp((u - high) / reach)
    falling -= 1.0
    weight = ((values["twist"] * u + values["bulge"]) * u + values["tilt"]) * u
    return np.asarray(weight * (rising - falling) + values["skew"] * (rising**2 - falling**2))


LINK = Link(
    name="asymmetric_hysteresis",
    stage=Stage.MATERIAL,
    order=10,
    title="asymmetric hysteresis",
    source="after Zhu and Wang 2012 (paper, reference [20]); Song and Der Kiureghian 2006",
    parameters=(
        Parameter("tilt", "m/V", 1e-9, -1e-3, 1e-3, "of the branches, with voltage", 0.0),
        Parameter("bulge", "m/V^2", 1e-11, -1e-4, 1e-4, "with its square", 0.0),
        Parameter("twist", "m/V^3", 1e-13, -1e-5, 1e-5, "with its cube", 0.0),
        Parameter("skew", "m", 1e-7, -1e-2, 1e-2, "of both branches, far from a turn", 0.0),
        Parameter("reach", "V", 15.0, 1e-3, 1e4, "travel over which a turn is forgotten"),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    plausible=plausible,
    says=says,
)
