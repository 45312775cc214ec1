"""Inverse Bouc-Wen models: the voltage for a wanted displacement.

Two of them, one contract. Both carry the voltage u and the hysteresis h that the model has by now,
and hold one step of the chain's closed form to move h.

- `ExactInverse`: solves one held step for the voltage at which the settled plant stands where it
  should, to the last digit. Blind to inertia and damping.
- `PaperInverse`, equation (6): explicit, with inertia and damping. Its h is that of the step
  before, so each tick leaves the share dh / (d du) of the voltage's change uncancelled: an error
  proportional to the sample period T. For the paper's piezo the share is alpha = 0.08 at h = 0 and
  up to 0.6 after a reversal of a full cycle.

Which is better follows from two delays: b / (k + k_s) of the mechanics, which the exact inverse
leaves, and T dh / (d du), which equation (6) leaves. The paper's piezo has 3 us against 80 us and
more at 1 kHz: the exact inverse, up to some ten kilohertz. A slow, damped gripper sampled fast
enough to see it move has it the other way round: equation (6).
"""

from __future__ import annotations

import enum
import math
from abc import ABC, abstractmethod

from microgripper_control.control.identified import Identified
from microgripper_control.core.compiled import compiled
from microgripper_control.effects.material.bouc_wen import advance, slope

MOST_ITERATIONS = 200  # bisection alone needs 60
CLOSE_ENOUGH = 1e-14  # of the voltage's travel


class Inverse(ABC):
    """The contract: `step` answers, `applied` tells which voltage the plant really got.

    Begins at rest: 0 V, never driven, and with a setpoint that was held. The order each tick is
    `applied(u[k])`, then `step`, whose answer is meant for the step after u[k]; where no limit and
    no delay comes between, `applied` is told the answer itself.
    """

    def __init__(self, identified: Identified, voltage_range: tuple[float, float]) -> None:
        self._model = identified
        self._low, self._high = voltage_range
        self._voltage = 0.0
        self._hysteresis = 0.0
        self._foreseen = math.nan, math.nan  # a voltage, V, and the h that it leads to, m

    @property
    def voltage(self) -> float:
        """The voltage last told, V."""
        return self._voltage

    @property
    def hysteresis(self) -> float:
        """The model's h at that voltage, m."""
        return self._hysteresis

    @property
    def displacement(self) -> float:
        """Where the model settles at that voltage, m."""
        return self._model.compliance * (self._model.d * self._voltage - self._hysteresis)

    def applied(self, voltage: float) -> None:
        """Move the model to a voltage, V, by one way; it must be finite."""
        foreseen, hysteresis = self._foreseen
        if voltage != foreseen:
            v = self._model
            change = voltage - self._voltage
            hysteresis = advance(self._hysteresis, change, v.a, v.beta, v.gamma, v.n)
        self._voltage, self._hysteresis = voltage, hysteresis
        self._foreseen = math.nan, math.nan

    def restart(self) -> None:  # noqa: B027 (most remember none)
        """Forget the setpoints so far: the next is taken as one that was held."""

    def take_over(self, other: Inverse) -> None:
        """Go on from the state of another, when the identified values change."""
        self._voltage, self._hysteresis = other.voltage, other.hysteresis
        self._foreseen = math.nan, math.nan

    @abstractmethod
    def step(self, setpoint: float) -> float:
        """The voltage, V, within the range, for a setpoint, m, finite."""


class PaperInverse(Inverse):
    """Equation (6): u = m/(k d) x'' + b/(k d) x' + (1/d + k_s/(k d)) x + h/d.

    x' and x'' are backward differences of the setpoint.
    """

    def __init__(
        self, identified: Identified, voltage_range: tuple[float, float], sample_period: float
    ) -> None:
        super().__init__(identified, voltage_range)
        force = identified.k * identified.d  # N/V
        self._inertia = identified.m / force / sample_period**2
        self._damping = identified.b / force / sample_period
        self.restart()

    def restart(self) -> None:
        """As the contract says."""
        self._last: float | None = None
        self._change = 0.0

    def step(self, setpoint: float) -> float:
        """As the contract says."""
        change = 0.0 if self._last is None else setpoint - self._last
        voltage = (
            self._inertia * (change - self._change)
            + self._damping * change
            + setpoint / self._model.gain
            + self._hysteresis / self._model.d
        )
        self._last, self._change = setpoint, change
        return min(max(voltage, self._low), self._high)


class ExactInverse(Inverse):
    """Solves d u - h(u) = (k + k_s)/k x for u, with h moved from where it is by one held step."""

    def __init__(self, identified: Identified, voltage_range: tuple[float, float]) -> None:
        super().__init__(identified, voltage_range)
        self.step(0.0)  # keeps nothing, but compiles now and not in the loop's first tick

    def step(self, setpoint: float) -> float:
        """As the contract says; an end of the range where no voltage in it will do."""
        v = self._model
        self._foreseen = solve_step(
            setpoint / v.compliance,
            self._voltage,
            self._hysteresis,
            self._low,
            self._high,
            v.d,
            v.a,
            v.beta,
            v.gamma,
            v.n,
        )
        return self._foreseen[0]


class InverseKind(str, enum.Enum):
    """The inverses by name."""

    EXACT = "exact"
    PAPER = "equation_6"


def make_inverse(
    kind: InverseKind,
    identified: Identified,
    voltage_range: tuple[float, float],
    sample_period: float,
) -> Inverse:
    """The inverse of that name, at rest."""
    if kind is InverseKind.PAPER:
        return PaperInverse(identified, voltage_range, sample_period)
    return ExactInverse(identified, voltage_range)


@compiled
def solve_step(
    wanted: float,
    u: float,
    h: float,
    low: float,
    high: float,
    d: float,
    a: float,
    beta: float,
    gamma: float,
    n: float,
) -> tuple[float, float]:
    """The voltage in `low` .. `high`, V, that takes d u - h from (u, h) to `wanted`, m, one way.

    With the h, m, that it leads to.
    Newton's method inside a bracket, with the slope of the hysteresis' own equation; it bisects
    where Newton leaves the bracket. One end of the range if the free displacement there still
    falls short.
    """
    sign = 1.0 if wanted > d * u - h else -1.0
    end = high if sign > 0.0 else low
    travel = sign * (end - u)
    if travel <= 0.0:
        return end, advance(h, end - u, a, beta, gamma, n)
    short = sign * (d * end - advance(h, sign * travel, a, beta, gamma, n) - wanted)
    if not short > 0.0:
        return end, advance(h, end - u, a, beta, gamma, n)
    below, above = 0.0, travel
    xi = min(sign * (wanted - (d * u - h)) / d, travel)
    for _ in range(MOST_ITERATIONS):
        h_new = advance(h, sign * xi, a, beta, gamma, n)
        excess = sign * (d * (u + sign * xi) - h_new - wanted)
        if excess < 0.0:
            below = xi
        else:
            above = xi
        steepness = d - slope(sign * h_new, a, beta, gamma, n)
        new = xi - excess / steepness if steepness > 0.0 else above
        if not below <= new <= above:
            new = 0.5 * (below + above)
        done = abs(new - xi) <= CLOSE_ENOUGH * travel
        xi = new
        if done:
            break
    voltage = min(max(u + sign * xi, low), high)
    return voltage, advance(h, voltage - u, a, beta, gamma, n)
