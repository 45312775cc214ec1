"""What to expect of a Bouc-Wen model before it runs: bounded or not, and how far it may be driven.

With xi the travel of the voltage one way and g = h on the way up, -h on the way down, equation (2)
of the paper is dg/dxi = s(g) with

    s(g) = a - (beta + gamma) g^n   for g >= 0,      a + (beta - gamma) |g|^n   for g < 0,

a = alpha d > 0. Its zeros are h0 = (a/(beta + gamma))^(1/n) and -h1 = -(a/(gamma - beta))^(1/n),
where they exist. A small step to and fro changes h by -2 beta h |h|^(n-1) dxi. Classes and their
names after Ikhouane and Rodellar, Systems with Hysteresis (2007), table 2.1.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from microgripper_control.core.exponential import before_growth
from microgripper_control.effects.base import Values


class BehaviourClass(enum.Enum):
    """The classes that alpha >= 0 and d > 0 leave; the value says what each means."""

    ONE = "class I: h stays below h0, or falls to it, whatever the voltage does"
    TWO = "class II: h stays bounded as long as it starts within -h1 .. h1"
    FIVE = "class V: h is never fed and only decays"
    GROWING = "not bounded: the farther the voltage rises, the larger h, without limit"
    RATCHETING = "not bounded: small movements to and fro make h grow without limit"

    @property
    def bounded(self) -> bool:
        """Whether one bound on h holds for every course of the voltage."""
        return self in (BehaviourClass.ONE, BehaviourClass.TWO, BehaviourClass.FIVE)


@dataclass(frozen=True)
class Behaviour:
    """What the values of the link `bouc_wen` mean for h, m, and for the drive voltage, V."""

    kind: BehaviourClass
    growing_above: float  # m; on rising voltage h grows from where it is above this ...
    growing_below: float  # m; ... and below this: -h1 and h0, infinite where they do not exist
    turning_hysteresis: float  # m; |h| from which the displacement runs against the voltage
    first_rise: float  # V; from h = 0 up to the turning hysteresis
    escape: float  # V; from h = 0 until h is infinite, which takes n > 1; else infinite
    safe_span: float  # V; widest drive range whose steady cycle is monotone and that h survives


def classify(values: Values) -> BehaviourClass:
    """The class of the values of the link `bouc_wen` (d in m/V, beta, gamma in 1/(V m^(n-1)))."""
    above, below = values["beta"] + values["gamma"], values["beta"] - values["gamma"]
    if values["beta"] < 0.0:
        return BehaviourClass.RATCHETING
    if values["alpha"] == 0.0:
        bounded = above >= 0.0 and below >= 0.0
        return BehaviourClass.FIVE if bounded else BehaviourClass.GROWING
    if above <= 0.0:
        return BehaviourClass.GROWING
    return BehaviourClass.ONE if below >= 0.0 else BehaviourClass.TWO


def behaviour(values: Values) -> Behaviour:
    """Everything at once, for the values of the link `bouc_wen`.

    The free displacement d u - h turns where dg/dxi = s(g) exceeds d. On |g| <= H the largest s is
    a + c H^n with c = max(beta - gamma, -(beta + gamma)), so that it turns once H reaches

        H* = ((d - a) / c)^(1/n),       never if c <= 0 or h0 <= H*.

    In steady cycling g runs from -H to H; the range that builds up H* is the integral of dg/s(g)
    from -H* to H*. Where beta + gamma < 0 and n > 1, h is infinite after the integral of dg/s(g)
    from 0 to infinity.
    """
    kind = classify(values)
    h0 = _zero(values, values["beta"] + values["gamma"])
    h1 = _zero(values, values["gamma"] - values["beta"])
    turning = _turning_hysteresis(values)
    reached = values["alpha"] > 0.0 and turning < h0
    escape = _escape(values)
    safe = min(_travel(values, -turning, turning) if reached else math.inf, escape)
    if kind is BehaviourClass.RATCHETING:
        safe = 0.0
    return Behaviour(
        kind=kind,
        growing_above=-h1,
        growing_below=h0,
        turning_hysteresis=turning,
        first_rise=_travel(values, 0.0, turning) if reached else math.inf,
        escape=escape,
        safe_span=safe,
    )


def _zero(values: Values, coefficient: float) -> float:
    """The |g| at which a - coefficient |g|^n vanishes, m; infinite if never."""
    if coefficient <= 0.0:
        return math.inf
    return float((values["alpha"] * values["d"] / coefficient) ** (1.0 / values["n"]))


def _turning_hysteresis(values: Values) -> float:
    above, below = values["beta"] + values["gamma"], values["beta"] - values["gamma"]
    steepest = max(below, -above)
    if steepest <= 0.0:
        return math.inf
    rest = (1.0 - values["alpha"]) * values["d"]
    return float((rest / steepest) ** (1.0 / values["n"]))


def _escape(values: Values) -> float:
    """The integral of dg/(a + c g^n) from 0 to infinity with c = -(beta + gamma), V."""
    a, n = values["alpha"] * values["d"], values["n"]
    c = -(values["beta"] + values["gamma"])
    if c <= 0.0 or a == 0.0 or n == 1.0:
        return math.inf
    return float((a / c) ** (1.0 / n) / a * math.pi / (n * math.sin(math.pi / n)))


def _travel(values: Values, start: float, end: float) -> float:
    """The travel of the voltage, V, in which g goes from `start` <= 0 to `end` >= 0, m."""
    a, n = values["alpha"] * values["d"], values["n"]
    above, below = values["beta"] + values["gamma"], values["beta"] - values["gamma"]
    if n == 1.0:  # the integral of dq/(a + c q) from 0 to g is ln(1 + c g/a)/c
        return before_growth(-start / a, below) + before_growth(end / a, -above)
    from scipy.integrate import quad  # takes 0.2 s to import: not for a node

    size = max(-start, end)
    # In units of the largest g: the absolute tolerance of the quadrature suits numbers near 1.
    falling = quad(lambda q: size / (a + below * (size * q) ** n), 0.0, -start / size)[0]
    rising = quad(lambda q: size / (a - above * (size * q) ** n), 0.0, end / size)[0]
    return float(falling + rising)
