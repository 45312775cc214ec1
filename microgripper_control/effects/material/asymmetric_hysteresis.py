"""Hysteresis whose rising and falling branches differ by more than beta and gamma give.

    w_a = w - (tilt u + bulge u^2 + twist u^3 + skew s) s - z
    s' = (sgn u' - s) |u'| / reach
    (h + z)' = feed u' - beta |u'| (h + z) - gamma u' |h + z| + delta u |u'|
               - (onward + backward) / 2 u' (h + z) - (onward - backward) / 2 |u'| |h + z|

s is the direction in which the voltage goes, +-1, as the material remembers it: after a turn it
changes over within a travel of `reach`. Its weight follows the voltage, so the branches part by
`tilt` more towards one end of the range, by `bulge` more in the middle or at both ends, by `twist`
one way in its lower and the other way in its upper part; `skew` moves both branches where they are
far from a turn. Only the way counts, not the speed. A weight without u is left out: that is a loop
as h is one.

z is what two kinds of terms in h' add to h, if beta and gamma are those of h: Zhu and Wang's delta
u |u'|, and Song and Der Kiureghian's, by which the voltage's direction decides how soon h is
forgotten: on its way from zero at beta + gamma +- onward, on its way back at beta - gamma +-
backward, + for a rising voltage. What feeds h, alpha d, is read off its own course.

With `plays` above zero there is a loop of plays besides, whose edges bend (`bent_plays`): they add
`plays` times what they lag behind the voltage or, where they are `relative`, plays whose edges are
alike. A fit then leaves the rest of the law as it is.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from itertools import product

import numpy as np

from microgripper_control.core.compiled import compiled, inlined
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent
from microgripper_control.core.signals import (
    FEED,
    FREE,
    HIGH,
    HYSTERESIS,
    LEVELS,
    LOOPS,
    LOW,
    PLACES,
    ROWS,
    VOLTAGE,
    Array,
    Timing,
)
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values
from microgripper_control.effects.bent_plays import (
    FALL,
    RISE,
    SHAPE,
    STATES,
    crossing,
    edges,
    move_bent_plays,
)
from microgripper_control.effects.material import bouc_wen
from microgripper_control.effects.material.bouc_wen import filled
from microgripper_control.effects.past import ways

MOST_STEPS, CLOSE = 30, 1e-9  # to where h + z passes zero, and of the way how close it is found
TELLING = 1e-6  # V: a way that is shorter shows rounding more than what feeds h
LOOP = 400  # samples of the largest loop, each way,
CLOSED = 20  # times round until its end is its beginning,
SETTLED = 1e-3  # of z: what it may still change by in the last
LOOP_REACH = 65.0  # V, over which the paper's h forgets
PAPERS_FEED = 0.08  # of the displacement: what feeds the paper's h
LEAST_BENT = 0.15  # of the widest play,
ALIKE = 4.0  # times what the edges differ: the most that both bend,
CROSSED = 2.0  # times what parts the plays: the most that their edges may be apart,
RULED_OUT = 3.0  # how unusual half or twice of that is
TINY = 1e-30
U_SO_FAR, H_SO_FAR, PLAYS_FROM = 2, 3, 6  # in the state
BETA = 6  # in a row
OF_H = ("delta", "onward", "backward")
OWN = ("tilt", "bulge", "twist", "skew", "reach", "delta", "beta", "gamma", "onward", "backward")


@inlined
def fed(g: float, level: float, slope: float, xi: float, c: float) -> float:
    """g after xi, V, where dg/dxi = level + slope xi - c g."""
    grown = filled(c, xi)
    small = abs(c * xi) < 0.02
    rest = xi * xi * (0.5 - c * xi / 6.0) if small else (xi - grown) / c
    return g * (1.0 - c * grown) + level * grown + slope * rest


@compiled
def _passing_once(
    g: float, level: float, slope: float, xi: float, ahead: float, back: float
) -> float:
    positive = g > 0.0 or (g == 0.0 and level + slope * xi > 0.0)
    c = ahead if positive else back
    new = fed(g, level, slope, xi, c)
    if g == 0.0 or new * g >= 0.0:
        return new
    low, high, passed = 0.0, xi, xi * g / (g - new)
    for _ in range(MOST_STEPS):  # Newton's within a bracket
        at = fed(g, level, slope, passed, c)
        low, high = (passed, high) if at * g > 0.0 else (low, passed)
        speed = level + slope * passed - c * at
        step = at / speed if speed != 0.0 else xi
        if abs(step) < CLOSE * xi:
            break
        passed = passed - step if low < passed - step < high else 0.5 * (low + high)
    return fed(0.0, level + slope * passed, slope, xi - passed, back if positive else ahead)


@compiled
def carried(g: float, level: float, slope: float, xi: float, ahead: float, back: float) -> float:
    """The same with `ahead` for c where g > 0 and `back` where g < 0."""
    if level * (level + slope * xi) < 0.0:  # before and after that it passes zero once each
        first = -level / slope
        g = _passing_once(g, level, slope, first, ahead, back)
        return _passing_once(g, 0.0, slope, xi - first, ahead, back)
    return _passing_once(g, level, slope, xi, ahead, back)


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: s, z, the voltage and h so far, what feeds h, how far the plays are behind, and they.

    A row: as `prepare` has it.
    """
    c = coefficients[0]
    s, z, old, before, feed, behind = state[0], state[1], state[2], state[3], state[4], state[5]
    ahead, back = c[6] + c[7], c[6] - c[7]
    moves_h = c[5] != 0.0 or c[8] != 0.0 or c[9] != 0.0
    for j in range(bus.shape[1]):
        u, h = bus[VOLTAGE, j], bus[HYSTERESIS, j]
        if u != old:
            xi, sign = abs(u - old), 1.0 if u > old else -1.0
            kept = math.exp(-xi / c[4])
            s = kept * s + sign * (1.0 - kept)
            if moves_h:
                if before * h >= 0.0 and xi > TELLING:  # elsewhere it is what it was
                    decay = ahead if (before + h) * sign > 0.0 else back
                    grown = filled(decay, xi)
                    feed = sign * (h - before) / grown + sign * decay * before
                own = carried(sign * before, feed, 0.0, xi, ahead, back)
                g, level = sign * (before + z), feed + sign * c[5] * old
                onward, backward = ahead + sign * c[8], back + sign * c[9]
                z = sign * (carried(g, level, c[5], xi, onward, backward) - own)
            if c[10] != 0.0:
                behind = move_bent_plays(state[PLAYS_FROM:], u, c[11:])
            old, before = u, h
        bus[FREE, j] -= (((c[2] * u + c[1]) * u + c[0]) * u + c[3] * s) * s + z
        if c[10] != 0.0:
            bus[FREE, j] += c[10] * behind
    state[0], state[1], state[2], state[3], state[4], state[5] = s, z, old, before, feed, behind


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """At rest a material remembers the way that h tells of."""
    row = np.array([[*(values[name] for name in (*OWN, "plays")), *edges(values)]])
    low, high, feed = (float(levels[i]) for i in (LOW + VOLTAGE, HIGH + VOLTAGE, FEED))
    nowhere = np.zeros(PLAYS_FROM + STATES)
    everywhere = _after(row, nowhere, (high, low) * int(levels[LOOPS]), feed)
    state = np.zeros_like(nowhere)
    for share, way in ways(levels, VOLTAGE):
        state += share * _after(row, everywhere if len(way) > 1 else nowhere, way, feed)
    state[H_SO_FAR] = levels[HYSTERESIS]
    ends = (_after(row, everywhere, way, feed) for way in ((high, low), (low, high)))
    for place, there in zip(PLACES, (state, *ends), strict=True):
        levels[place + FREE] += _adds(row, there)
    return Prepared(row, state, timing.ramped)


def _after(row: Array, before: Array, way: tuple[float, ...], feed: float) -> Array:
    """The state after a way, V, from the state `before` it; `feed` is alpha d, m/V.

    On it h goes by the link's own beta and gamma, so that what feeds it is read off rightly.
    """
    bus, state = np.zeros((ROWS, len(way))), np.array(before)
    bus[VOLTAGE] = way
    u, h = float(state[U_SO_FAR]), float(state[H_SO_FAR])
    for j, volts in enumerate(way):
        h = bouc_wen.advance(h, volts - u, feed, row[0, BETA], row[0, BETA + 1], 1.0)
        bus[HYSTERESIS, j], u = h, volts
    kernel(row, state, bus)
    return state


def _adds(row: Array, state: Array) -> float:
    """What the link adds to the free displacement, m, while nothing moves."""
    still = np.zeros((ROWS, 1))
    still[VOLTAGE], still[HYSTERESIS] = state[U_SO_FAR], state[H_SO_FAR]
    kernel(row, state, still)
    return float(still[FREE, 0])


def starts(scales: Scales) -> Sequence[Values]:
    """Each of the ways by itself, a hundredth of the stroke, with two memories; plays of two sizes.

    One edge of the plays bows, up or down, or, where they are relative, with the voltage.
    """
    u, swing = max(abs(volts) for volts in scales.voltage), scales.swing
    size = 0.01 * scales.stroke
    off = {"tilt": 0.0, "bulge": 0.0, "twist": 0.0, "skew": 0.0, **dict.fromkeys(OF_H, 0.0)}
    branches = {"tilt": size / u, "bulge": size / u**2, "twist": size / u**3, "skew": size}
    beside = [
        off | {name: way, "reach": share * swing}
        for share in (0.08, 0.2)
        for name, way in branches.items()
    ]
    low, high = scales.voltage
    straight = {"lowest": low, "highest": high, **dict.fromkeys((*RISE, *FALL), 0.0)}
    plays = off | straight | {"plays": 0.3 * scales.stroke / swing}
    bent = [
        plays | {"widest": width * swing, edge: bow * swing}
        for width, edge, bow in product((0.2, 0.4), ("rise_bow", "fall_bow"), (-0.05, 0.05))
    ]
    unlike = [
        plays | {"relative": 1.0, "widest": width * swing, bend: size * swing}
        for width, bend, size in product((0.1, 0.3), RISE[:2], (-0.1, 0.1))
    ]
    of_h = [
        {"delta": size / (u * LOOP_REACH)},
        *({name: sooner} for name, sooner in product(OF_H[1:], (0.4 / swing, -0.4 / swing))),
    ]
    return [*beside, *(off | way for way in of_h), *bent, *unlike]


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A turn is forgotten within the swing, as the paper's beta has it.

    With a longer reach s would be the voltage itself, and the loop a bent line; with a shorter one
    the branches would jump apart. Edges that bend by much would be no edges.
    """
    bow, swing = 0.6 * scales.swing, scales.swing
    bent = dict.fromkeys((*RISE, *FALL), (-bow, bow))
    return {
        "reach": (0.02 * swing, 0.6 * swing),
        "widest": (0.01 * swing, 0.6 * swing),
        "plays": (0.0, 20.0 * scales.stroke / swing),
    } | bent


def idle(values: Values) -> Collection[str]:
    """Plays are left out if they start like that, and are else all there is.

    Edges curl only where the plays are relative: others would take a bent line for a loop.
    """
    if values["plays"] == 0.0:
        return "plays", "widest", "taper", *SHAPE
    return OWN if values["relative"] else (*OWN, "rise_curl", "fall_curl")


def unusual(values: Values, scales: Scales) -> float:
    """Plays whose edges cross, and others whose edges hardly bend or bend alike, are not lopsided.

    The first and the last make a bent line, for which there are other names, the second is Prandtl
    and Ishlinskii's own loop, for which there is none here.
    """
    if values["plays"] == 0.0:
        return 0.0
    octaves = math.log2(max(crossing(values), TINY) / CROSSED)
    if not values["relative"]:
        rise, fall = (np.array([values[name] for name in edge]) for edge in (RISE, FALL))
        bent = max(np.max(np.abs(rise)), np.max(np.abs(fall))) / values["widest"]
        alike = np.max(np.abs(rise + fall)) / max(np.max(np.abs(fall - rise)), TINY)
        octaves = max(
            octaves, math.log2(LEAST_BENT / max(bent, TINY)), math.log2(max(alike, TINY) / ALIKE)
        )
    return RULED_OUT * min(1.0, max(0.0, octaves))


def says(values: Values, scales: Scales) -> str:
    share = percent(float(np.max(np.abs(apart(values, scales)))) / scales.stroke)
    return (
        "the hysteresis is lopsided: between rising and falling voltage the branches lie up to "
        f"{share} of the stroke closer together, or further apart, than the model's"
    )


def apart(values: Values, scales: Scales) -> Array:
    """How much further than the paper's the branches of the largest loop are apart, m, (50,).

    At voltages evenly over it, with an h like the paper's. Where a loop grows from round to round
    or beyond all bounds, z is left out.
    """
    low, high = scales.voltage
    rise = np.linspace(low, high, LOOP + 1)
    levels = np.zeros(LEVELS)
    levels[VOLTAGE] = low
    loop = np.zeros((ROWS, 2 * LOOP))
    loop[VOLTAGE] = np.append(rise[1:], rise[-2::-1])
    feed = PAPERS_FEED * scales.stroke / scales.swing
    material = np.array([[0.0, feed, values["beta"], values["gamma"], 1.0]])
    h, link = levels[[VOLTAGE, HYSTERESIS]], prepare(values, Timing(1.0, (1.0,), True), levels)
    before = z = 0.0
    for _ in range(CLOSED):
        before = z
        bouc_wen.kernel(material, h, loop)
        loop[FREE] = 0.0
        kernel(link.coefficients, link.state, loop)
        z = float(link.state[1])
    settled = abs(z - before) <= SETTLED * abs(before)
    bounded = np.max(np.abs(loop[FREE])) < scales.stroke  # nor if it has overflowed
    if not (settled and bounded) and any(values[name] != 0.0 for name in OF_H):
        return apart({**values, **dict.fromkeys(OF_H, 0.0)}, scales)
    u = np.linspace(low, high, 50)
    rising = np.interp(u, rise[1:], loop[FREE, :LOOP])
    falling = np.interp(u, rise[:-1], loop[FREE, : LOOP - 1 : -1])
    return np.asarray(falling - rising)


LINK = Link(
    name="asymmetric_hysteresis",
    stage=Stage.MATERIAL,
    order=10,
    title="asymmetric hysteresis",
    source=(
        "after Zhu and Wang 2012 (paper, reference [20]); Song and Der Kiureghian 2006; "
        "Al Janaideh, Rakheja, Su 2011"
    ),
    parameters=(
        Parameter("tilt", "m/V", 1e-9, -1e-3, 1e-3, "how far the branches part, per volt", 0.0),
        Parameter(
            "bulge", "m/V^2", 1e-11, -1e-4, 1e-4, "the same by the square of the voltage", 0.0
        ),
        Parameter("twist", "m/V^3", 1e-13, -1e-5, 1e-5, "the same by its cube", 0.0),
        Parameter("skew", "m", 1e-7, -1e-2, 1e-2, "shift of both branches far from a turn", 0.0),
        Parameter("reach", "V", 15.0, 1e-3, 1e4, "travel over which a turn is forgotten"),
        Parameter(
            "delta",
            "m/V^2",
            1e-12,
            -1e-3,
            1e-3,
            "what each volt adds to the loop per volt of travel",
            0.0,
        ),
        Parameter("beta", "1/V", 0.0152, 0.0, 1e3, "decay of the loop with travel, both ways"),
        Parameter("gamma", "1/V", -0.0227, -1e3, 1e3, "decay of the loop by direction"),
        Parameter(
            "onward", "1/V", 0.0, -0.2, 0.2, "sooner forgotten on a rise, away from zero", 0.0
        ),
        Parameter("backward", "1/V", 0.0, -0.2, 0.2, "the same on its way back to zero", 0.0),
        Parameter("plays", "m/V", 0.0, 0.0, 1e-3, "slope of the loop that plays make", 0.0),
        Parameter("widest", "V", 30.0, 1e-3, 1e4, "threshold of the widest play"),
        Parameter(
            "taper", "1", 0.5, -10.0, 10.0, "how much less wide plays count than narrow ones"
        ),
        Parameter("rise_bow", "V", -5.0, -1e4, 1e4, "bow of the rising edge amid the range"),
        Parameter("rise_skew", "V", -2.0, -1e4, 1e4, "how much more it bows below than above"),
        Parameter("rise_curl", "V", 0.0, -1e4, 1e4, "how much later it bows that way"),
        Parameter("fall_bow", "V", 5.0, -1e4, 1e4, "bow of the falling edge"),
        Parameter("fall_skew", "V", 2.0, -1e4, 1e4, "how much more it bows below than above"),
        Parameter("fall_curl", "V", 0.0, -1e4, 1e4, "how much later it bows that way"),
        Parameter("lowest", "V", 0.0, -1e4, 1e4, "from where the edges bend", fitted=False),
        Parameter("highest", "V", 150.0, -1e4, 1e4, "up to where they bend", fitted=False),
        Parameter(
            "relative",
            "1",
            0.0,
            0.0,
            1.0,
            "1 if less what plays with the mean edges do",
            fitted=False,
        ),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    plausible=plausible,
    idle=idle,
    unusual=unusual,
    says=says,
)
