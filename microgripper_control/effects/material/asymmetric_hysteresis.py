"""Hysteresis whose rising and falling branches differ by more than beta and gamma give.

    w_a = w - (tilt u + bulge u^2 + twist u^3 + skew s) s - z
    s' = (sgn u' - s) |u'| / reach
    z' = (delta u - (1 + lean sgn(u' h)) z / reach) |u'|

s is the direction in which the voltage goes, +-1, as the material remembers it: after a turn it
changes over within a travel of `reach`. Its weight follows the voltage, so the branches part by
`tilt` more towards one end of the range, by `bulge` more in the middle or at both ends, by `twist`
one way in its lower and the other way in its upper part; `skew` moves both branches where they are
far from a turn. Only the way counts, not the speed. A weight without u is left out: that is a loop
as h is one.

z keeps what was written at a voltage until it is forgotten as h is: it is what Zhu and Wang's term
delta u |u'| in h' adds to h, as long as that does not change the sign of h, with 1 / reach for beta
and `lean` for gamma / beta. Put beside h instead of into h' it leaves the closed form of h alone.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent
from microgripper_control.core.signals import FREE, HYSTERESIS, ROWS, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values
from microgripper_control.effects.material.bouc_wen import filled

LOOP = 400  # samples of the largest loop, each way,
CLOSED = 20  # times round until its end is its beginning,
SETTLED = 1e-3  # of z: what it may still change by in the last


@compiled
def written(z: float, delta: float, u: float, way: float, c: float) -> float:
    """z after the voltage moved on from u by `way`, V, where dz/d|u| = delta u - c z."""
    xi, sign = abs(way), 1.0 if way > 0.0 else -1.0
    share = filled(c, xi)
    small = abs(c * xi) < 0.02
    rest = xi * xi * (0.5 - c * xi / 6.0) if small else (xi - share) / c
    return z * (1.0 - c * share) + delta * (u * share + sign * rest)


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: s, z, the voltage and h so far. A row: as `prepare` has it."""
    c = coefficients[0]
    s, z, old, before = state[0], state[1], state[2], state[3]
    ahead, back = (1.0 + c[6]) / c[4], (1.0 - c[6]) / c[4]
    for j in range(bus.shape[1]):
        u, h = bus[VOLTAGE, j], bus[HYSTERESIS, j]
        if u != old:
            kept = math.exp(-abs(u - old) / c[4])
            s = kept * s + (1.0 - kept if u > old else kept - 1.0)
            if c[5] != 0.0:
                way = u - old
                if before * way < 0.0:
                    to_zero = way if h * way <= 0.0 else way * before / (before - h)
                    z = written(z, c[5], old, to_zero, back)
                    way -= to_zero
                z = written(z, c[5], u - way, way, ahead)
            old, before = u, h
        bus[FREE, j] -= (((c[2] * u + c[1]) * u + c[0]) * u + c[3] * s) * s + z
    state[0], state[1], state[2], state[3] = s, z, old, before


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: a material at rest remembers no direction."""
    row = [values[name] for name in ("tilt", "bulge", "twist", "skew", "reach", "delta", "lean")]
    state = np.array([0.0, 0.0, levels[VOLTAGE], levels[HYSTERESIS]])
    return Prepared(np.array([row]), state, timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Each of the ways by itself, a hundredth of the stroke, with two memories."""
    u, size = max(abs(volts) for volts in scales.voltage), 0.01 * scales.stroke
    off = {"tilt": 0.0, "bulge": 0.0, "twist": 0.0, "skew": 0.0, "delta": 0.0}
    ways = {"tilt": size / u, "bulge": size / u**2, "twist": size / u**3, "skew": size}
    beside = [
        off | {name: way, "reach": share * scales.swing}
        for share in (0.08, 0.2)
        for name, way in ways.items()
    ]
    reach = 0.4 * scales.swing
    return [*beside, off | {"delta": size / (u * reach), "reach": reach}]


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

    At voltages evenly over it. h is taken to change its sign as s does. Where `reach` is short and
    `lean` feeds z, it grows from round to round: there is no largest loop then, and z is left out.
    """
    low, high = scales.voltage
    rise = np.linspace(low, high, LOOP + 1)
    way = np.arange(1, LOOP + 1) * (high - low) / LOOP / values["reach"]
    sign = 1.0 - (1.0 + math.tanh(0.5 * way[-1])) * np.exp(-way)
    levels = np.zeros(ROWS)
    levels[VOLTAGE] = low
    link = prepare(values, Timing(1.0, (1.0,), True), levels)
    bus = np.zeros((ROWS, 2 * LOOP))
    bus[VOLTAGE] = np.append(rise[1:], rise[-2::-1])
    bus[HYSTERESIS] = np.append(sign, -sign)
    before = z = 0.0
    for _ in range(CLOSED):
        before = z
        bus[FREE] = 0.0
        kernel(link.coefficients, link.state, bus)
        z = float(link.state[1])
    if not abs(z - before) <= SETTLED * abs(before):  # nor if it has overflowed
        return apart({**values, "delta": 0.0}, scales)
    u = np.linspace(low, high, 50)
    rising = np.interp(u, rise[1:], bus[FREE, :LOOP])
    falling = np.interp(u, rise[:-1], bus[FREE, : LOOP - 1 : -1])
    return np.asarray(falling - rising)


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
        Parameter("delta", "m/V^2", 1e-12, -1e-3, 1e-3, "written into the loop, with voltage", 0.0),
        Parameter("lean", "1", -1.5, -10.0, 10.0, "gamma over beta of the loop", fitted=False),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    plausible=plausible,
    says=says,
)
