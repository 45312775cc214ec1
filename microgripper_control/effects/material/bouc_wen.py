"""Bouc-Wen hysteresis between voltage and free displacement, the paper's equations (1)-(3).

    h' = alpha d u' - beta |u'| h |h|^(n-1) - gamma u' |h|^n,        w = d u - h

Only the course of u matters, not its speed. Over a step on which u moves one way by du, with
xi = |u - u0| and g = sign(du) h, both directions obey

    dg/dxi = alpha d - beta g |g|^(n-1) - gamma |g|^n,

so that on each side of g = 0 the coefficient is constant: beta + gamma above, beta - gamma below.
For n = 1 that is linear, and the step is taken in closed form, split where g changes sign. For
other exponents it is integrated by the classical Runge-Kutta method with steps small against the
curvature, split at the same place because |g|^n is not smooth there.
"""

import math

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import FREE, HYSTERESIS, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Stage, Values

LARGEST_CURVATURE = 0.05  # of one Runge-Kutta step: its error is then below 1e-8 of h


@compiled
def _relax(g: float, a: float, c: float, xi: float) -> float:
    """Solve dg/dxi = a - c g from g over xi (n = 1, one side of zero)."""
    x = c * xi
    if abs(x) < 1e-12:
        return g + (a - c * g) * xi
    return g - (g - a / c) * -math.expm1(-x)


@compiled
def _travel_to_zero(g: float, a: float, c: float) -> float:
    """The xi at which dg/dxi = a - c g, started at g < 0, reaches zero; infinite if never."""
    slope = a - c * g
    if slope <= 0.0 or a <= 0.0:
        return math.inf
    if abs(c * g) < 1e-12 * a:
        return -g / a
    return math.log1p(-c * g / a) / c


@compiled
def slope(g: float, a: float, beta: float, gamma: float, n: float) -> float:
    """dg/dxi at g, m/V; arguments as in `advance`."""
    size: float = abs(g) ** n
    return a - gamma * size - (beta * size if g >= 0.0 else -beta * size)


@compiled
def _runge_kutta(g: float, a: float, beta: float, gamma: float, n: float, step: float) -> float:
    s1 = slope(g, a, beta, gamma, n)
    s2 = slope(g + 0.5 * step * s1, a, beta, gamma, n)
    s3 = slope(g + 0.5 * step * s2, a, beta, gamma, n)
    s4 = slope(g + step * s3, a, beta, gamma, n)
    return g + step / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4)


@compiled
def _integrate_power(g: float, a: float, beta: float, gamma: float, n: float, xi: float) -> float:
    """Solve dg/dxi = a - beta g |g|^(n-1) - gamma |g|^n from g over xi, for n > 1."""
    left = xi
    while left > 0.0:
        c = max(abs(beta + gamma), abs(beta - gamma))
        reach = abs(g) + a * left
        curvature = c * n * reach ** (n - 1.0) * left
        step = left * min(1.0, LARGEST_CURVATURE / max(curvature, 1e-300))
        new = _runge_kutta(g, a, beta, gamma, n, step)
        if g < 0.0 < new:
            # Near zero g runs at the slope a: aim the step at the crossing, then go on from there.
            step = min(step, -g / a)
            for _ in range(20):
                new = _runge_kutta(g, a, beta, gamma, n, step)
                step -= new / slope(new, a, beta, gamma, n)
                if abs(new) <= 1e-15 * reach:
                    break
            new = 0.0
        if not math.isfinite(new):
            return new
        g = new
        left -= step
    return g


@compiled
def advance(h: float, du: float, a: float, beta: float, gamma: float, n: float) -> float:
    """Return h after the voltage moved one way by `du`, V (equations (2), (3)).

    `h` in m, `a` = alpha d in m/V, `beta` and `gamma` in 1/(V m^(n-1)).
    """
    if du == 0.0:
        return h
    sign = 1.0 if du > 0.0 else -1.0
    xi = abs(du)
    g = sign * h
    if n != 1.0:
        return sign * _integrate_power(g, a, beta, gamma, n, xi)
    if g < 0.0:
        c = beta - gamma
        to_zero = _travel_to_zero(g, a, c)
        if xi <= to_zero:
            return sign * _relax(g, a, c, xi)
        xi -= to_zero
        g = 0.0
    return sign * _relax(g, a, beta + gamma, xi)


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    d, a, beta = coefficients[0, 0], coefficients[0, 1], coefficients[0, 2]
    gamma, n = coefficients[0, 3], coefficients[0, 4]
    u, h = state[0], state[1]
    for j in range(bus.shape[1]):
        new = bus[VOLTAGE, j]
        h = advance(h, new - u, a, beta, gamma, n)
        u = new
        bus[HYSTERESIS, j] = h
        bus[FREE, j] = d * u - h
    state[0], state[1] = u, h


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """State: the voltage and h so far. The hysteresis is rate-independent: the course is kept."""
    d = values["d"]
    row = (d, values["alpha"] * d, values["beta"], values["gamma"], values["n"])
    levels[FREE] = d * levels[VOLTAGE] - levels[HYSTERESIS]
    state = np.array([levels[VOLTAGE], levels[HYSTERESIS]])
    return Prepared(np.array([row]), state, timing.ramped)


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
