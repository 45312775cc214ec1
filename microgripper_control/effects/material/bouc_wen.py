"""Bouc-Wen hysteresis between voltage and free displacement, the paper's equations (1)-(3).

    h' = alpha d u' - beta |u'| h |h|^(n-1) - gamma u' |h|^n,        w = d u - h

Only the course of u matters, not its speed. Over a step on which u moves one way by du, with
xi = |u - u0| and g = sign(du) h, both directions obey

    dg/dxi = alpha d - beta g |g|^(n-1) - gamma |g|^n,

so that on each side of g = 0 the coefficient is constant: beta + gamma above, beta - gamma below.
For n = 1 that is linear, for n = 2 Riccati's: the step is taken in closed form, split where g
changes sign. For other exponents it is integrated by the classical Runge-Kutta method with steps
small against the curvature, split at the same place and small near it because |g|^n is not smooth
there.
"""

import math

import numpy as np

from microgripper_control.core.compiled import compiled, inlined
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import (
    FALLEN,
    FEED,
    FREE,
    HIGH,
    HYSTERESIS,
    LOOPS,
    LOW,
    RISEN,
    VOLTAGE,
    Array,
    Timing,
)
from microgripper_control.effects.base import Link, Prepared, Stage, Values
from microgripper_control.effects.past import shares_of_ways

LARGEST_CURVATURE = 0.03  # of one Runge-Kutta step: its error is then below 1e-8 of h
SMALLEST_GROWTH = 0.15  # of |h|^n in one step, because |h|^n is not smooth at zero
STRAIGHT = 1e-8  # so near zero that the terms in |h|^n are less than this beside alpha d
SETTLED = 1e-6  # of the largest h: what a loop over all of the drive's range still changes it by
MOST_LOOPS = 300  # until then
FROM_REST = math.nan  # the level of an h that has come from rest, one way, with the voltage


@inlined
def filled(c: float, xi: float) -> float:
    """What dg/dxi = 1 - c g has made of zero after xi: (1 - exp(-c xi)) / c."""
    x = c * xi
    if abs(x) < 0.2:  # Pade: within 2e-14, and quicker
        y = x * x
        return (
            xi
            * (1.0 + y * (1 / 42))
            / (1.0 + x * (1 / 2) + y * (3 / 28 + x * (1 / 84) + y * (1 / 1680)))
        )
    return -math.expm1(-x) / c


@compiled
def _travel_to_zero(g: float, a: float, c: float) -> float:
    """The xi at which dg/dxi = a - c g, started at g < 0, reaches zero; it must do so."""
    if abs(c * g) < 1e-12 * a:
        return -g / a
    return math.log1p(-c * g / a) / c


@inlined
def _bent(c: float, a: float, xi: float) -> float:
    """What dg/dxi = a - c g^2 has made of zero after xi, over a: tanh(q xi) / q, q = sqrt(a c).

    Infinite where it has grown without bound, as a tangent does for c < 0.
    """
    y = a * c * xi * xi
    if abs(y) < 0.04:  # the tangents' continued fraction: within 1e-14, and quicker
        return xi / (1.0 + y / (3.0 + y / (5.0 + y / (7.0 + y / 9.0))))
    x = math.sqrt(abs(y))
    if y > 0.0:
        return xi * math.tanh(x) / x
    return xi * math.tan(x) / x if x < 0.5 * math.pi else math.inf


@inlined
def _step_square(g: float, a: float, c: float, xi: float) -> float:
    """Solve dg/dxi = a - c g^2 from g over xi, by the addition theorem of the tangents."""
    bent = _bent(c, a, xi)
    speed, under = a - c * g * g, 1.0 + c * g * bent
    return g + speed * bent / under if under > 0.0 else math.copysign(math.inf, speed)


@compiled
def _travel_to_zero_square(g: float, a: float, c: float) -> float:
    """As `_travel_to_zero`, of dg/dxi = a - c g^2."""
    x = g * math.sqrt(abs(c) / a)
    if abs(x) < 1e-6:
        return -g / a
    return -g / a * (math.atanh(x) if c > 0.0 else math.atan(x)) / x


@compiled
def _integrate_square(g: float, a: float, beta: float, gamma: float, xi: float) -> float:
    """Solve dg/dxi = a - beta g |g| - gamma g^2 from g over xi."""
    if g < 0.0:
        c = gamma - beta
        new = _step_square(g, a, c, xi)
        if new <= 0.0:
            return new
        xi -= _travel_to_zero_square(g, a, c)
        g = 0.0
    return _step_square(g, a, beta + gamma, xi)


@compiled
def slope(g: float, a: float, beta: float, gamma: float, n: float) -> float:
    """dg/dxi at g, m/V; arguments as in `advance`."""
    size: float = abs(g) ** n
    return a - gamma * size - (beta * size if g >= 0.0 else -beta * size)


@compiled
def _step_power(size: float, s1: float, a: float, c: float, n: float, most: float) -> float:
    """The largest step of xi, up to `most`, over which dg/dxi changes little, for n > 1.

    `size` is |g|, `s1` is dg/dxi, `c` the larger of |beta + gamma| and |beta - gamma|.
    """
    step, speed = most, abs(s1)
    if n * speed * step > SMALLEST_GROWTH * size:
        bend = abs(a - s1)
        growth = SMALLEST_GROWTH / n * ((bend + a) / bend) ** 0.25
        straight = (STRAIGHT * a / c) ** (1.0 / n)
        if size + speed * step > straight:
            step = min(step, max(min(0.5, growth) * size, straight) / speed)
    reach: float = (size + speed * step) ** (n - 1.0)
    return min(step, LARGEST_CURVATURE / (c * n * reach))


@compiled
def _integrate_power(g: float, a: float, beta: float, gamma: float, n: float, xi: float) -> float:
    """Solve dg/dxi = a - beta g |g|^(n-1) - gamma |g|^n from g over xi, for n > 1."""
    c = max(abs(beta + gamma), abs(beta - gamma))
    left = xi
    while left > 0.0 and math.isfinite(g):
        s1 = slope(g, a, beta, gamma, n)
        step = _step_power(abs(g), s1, a, c, n, left)
        if g < 0.0 < g + step * s1:
            step = -g / s1  # so near zero that it runs straight, and goes on from there
            g = 0.0
        else:
            s2 = slope(g + 0.5 * step * s1, a, beta, gamma, n)
            s3 = slope(g + 0.5 * step * s2, a, beta, gamma, n)
            s4 = slope(g + step * s3, a, beta, gamma, n)
            g += step / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4)
        left -= step
    return g


@inlined
def advance(h: float, du: float, a: float, beta: float, gamma: float, n: float) -> float:
    """Return h after the voltage moved one way by `du`, V (equations (2), (3)).

    `h` in m, `a` = alpha d in m/V, `beta` and `gamma` in 1/(V m^(n-1)).
    """
    if n != 1.0:
        sign = 1.0 if du >= 0.0 else -1.0
        if n == 2.0:
            return sign * _integrate_square(sign * h, a, beta, gamma, abs(du))
        return sign * _integrate_power(sign * h, a, beta, gamma, n, abs(du))
    # The step is linear in h: next to nothing to wait for from one step to the next.
    xi, feed = abs(du), a if du > 0.0 else -a
    if h * du < 0.0:
        c = beta - gamma
        grown = filled(c, xi)
        new = h * (1.0 - c * grown) + feed * grown
        if new * du <= 0.0:
            return new
        xi = max(0.0, xi - _travel_to_zero(-abs(h), a, c))  # rounding may have taken it there
        h = 0.0
    c = beta + gamma
    grown = filled(c, xi)
    return h * (1.0 - c * grown) + feed * grown


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    d, a, beta = coefficients[0, 0], coefficients[0, 1], coefficients[0, 2]
    gamma, n = coefficients[0, 3], coefficients[0, 4]
    u, h = state[0], state[1]
    for j in range(bus.shape[1]):
        new = bus[VOLTAGE, j]
        du = new - u
        if du != 0.0:  # a held voltage moves once a sample, however many steps that has
            h = advance(h, du, a, beta, gamma, n)
        u = new
        bus[HYSTERESIS, j] = h
        bus[FREE, j] = d * u - h
    state[0], state[1] = u, h


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """State: the voltage and h so far. The hysteresis is rate-independent: the course is kept."""
    d = values["d"]
    rows = np.array([[d, values["alpha"] * d, values["beta"], values["gamma"], values["n"]]])
    u, h = levels[VOLTAGE], levels[HYSTERESIS]
    if math.isnan(h):  # `FROM_REST`
        h = levels[HYSTERESIS] = advance(0.0, u, *rows[0, 1:])
    levels[FREE] = d * u - h
    _tell_of_the_past(rows[0], levels)
    state = np.array([u, h])
    return Prepared(rows, state, timing.ramped)


@compiled
def _settled_loop(
    low: float, high: float, a: float, beta: float, gamma: float, n: float
) -> tuple[float, float, int]:
    """h, m, at the ends of a loop, V, that has settled, and how often it was gone through."""
    bottom, top = 0.0, advance(0.0, high, a, beta, gamma, n)
    for loops in range(1, MOST_LOOPS + 1):
        before = top
        bottom = advance(top, low - high, a, beta, gamma, n)
        top = advance(bottom, high - low, a, beta, gamma, n)
        if not abs(top - before) > SETTLED * abs(top):
            return bottom, top, loops
    return bottom, top, MOST_LOOPS


@compiled
def _tell_of_the_past(c: Array, levels: Array) -> None:
    """Write what the drive's ends leave of h and displacement, and how far h speaks for each way.

    `c` is a row of the kernel's coefficients.
    """
    d, a, beta, gamma, n = c[0], c[1], c[2], c[3], c[4]
    u, h = levels[VOLTAGE], levels[HYSTERESIS]
    low, high = min(levels[LOW + VOLTAGE], u), max(levels[HIGH + VOLTAGE], u)
    bottom, top, loops = _settled_loop(low, high, a, beta, gamma, n)
    if not (math.isfinite(bottom) and math.isfinite(top)):
        return  # it is not bounded over so long a way: then as if it were the first
    for place, volts, left in ((LOW, low, bottom), (HIGH, high, top)):
        levels[place + VOLTAGE], levels[place + HYSTERESIS] = volts, left
        levels[place + FREE] = d * volts - left
    first = advance(0.0, u, a, beta, gamma, n)
    risen = advance(bottom, u - low, a, beta, gamma, n)
    fallen = advance(top, u - high, a, beta, gamma, n)
    levels[RISEN], levels[FALLEN] = shares_of_ways(h, first, risen, fallen)
    levels[FEED], levels[LOOPS] = a, loops


RATE_UNIT = "1/(V*m^(n-1))"

LINK = Link(
    name="bouc_wen",
    stage=Stage.MATERIAL,
    order=0,
    title="Bouc-Wen hysteresis",
    source="paper, equations (1)-(3) and Table 1; Bouc 1967, Wen 1976",
    nominal=True,
    parameters=(
        Parameter("d", "m/V", 1.4447e-7, 1e-12, 1.0, "effective piezoelectric coefficient"),
        Parameter("alpha", "1", 0.0801, 0.0, 0.95, "share of the voltage that feeds h"),
        Parameter("beta", RATE_UNIT, 0.0152, -1e9, 1e9, "decay of h with travel, both ways"),
        Parameter("gamma", RATE_UNIT, -0.0227, -1e9, 1e9, "decay of h by direction"),
        Parameter("n", "1", 1.0, 1.0, 5.0, "sharpness of the bend; 1 for a piezo", fitted=False),
    ),
    prepare=prepare,
    kernel=kernel,
)
