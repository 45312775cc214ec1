"""The identified values a controller holds of its plant, equations (1)-(4) of the paper.

    m x'' + b x' + (k + k_s) x = k (d u - h)
    h' = alpha d u' - beta |u'| h |h|^(n-1) - gamma u' |h|^n

They are values only: the controller never sees the plant it is tested against.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.effects.base import Link, Values
from microgripper_control.effects.material import bouc_wen
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.effects.mechanics import second_order

CYCLES_TO_SETTLE = 20  # between the voltage limits, until the loop closes


class Known(Protocol):
    """What a model tells a controller of its rig; V, s, s and m."""

    @property
    def voltage_range(self) -> tuple[float, float]: ...  # noqa: D102 (as Identified has them)

    @property
    def dead_time(self) -> float: ...  # noqa: D102

    @property
    def ringing(self) -> float: ...  # noqa: D102

    @property
    def zero(self) -> float: ...  # noqa: D102

    def values(self, link: str) -> Values: ...  # noqa: D102


@dataclass(frozen=True)
class Identified:
    """Checked at construction against the ranges that the links declare.

    Raises MicrogripperError naming the value and its range.
    """

    d: float  # m/V
    alpha: float
    beta: float  # 1/(V m^(n-1))
    gamma: float  # 1/(V m^(n-1))
    n: float
    m: float  # kg
    b: float  # N s/m
    k: float  # N/m
    k_s: float  # N/m
    voltage_range: tuple[float, float]  # V, for which these values hold
    dead_time: float = 0.0  # s by which the reading is behind the command, besides the mechanics
    ringing: float = 0.0  # s, largest |G(jw) - 1| / w of the modes G besides the mechanics
    zero: float = 0.0  # m, what the sensor reads at x = 0

    def __post_init__(self) -> None:
        for link in (bouc_wen.LINK, second_order.LINK):
            for parameter in link.parameters:
                parameter.check(getattr(self, parameter.name), f"identified: {link.name}")
        low, high = self.voltage_range
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise MicrogripperError(
                f"identified: voltage range {low:g} .. {high:g} V: low must be below high"
            )
        for name, time in ("dead time", self.dead_time), ("ringing", self.ringing):
            if not (math.isfinite(time) and time >= 0.0):
                raise MicrogripperError(f"identified: {name} {time:g} s: must be 0 or more")
        if not math.isfinite(self.zero):
            raise MicrogripperError(f"identified: zero {self.zero:g} m: must be finite")

    @classmethod
    def of(cls, model: Known) -> Identified:
        """What a controller needs of a model, its delays, lags and modes and its zero too."""
        material, mechanics = model.values("bouc_wen"), model.values("second_order")
        return cls.from_values(
            material, mechanics, model.voltage_range, model.dead_time, model.ringing, model.zero
        )

    @classmethod
    def from_values(
        cls,
        material: Values,
        mechanics: Values,
        voltage_range: tuple[float, float],
        dead_time: float = 0.0,
        ringing: float = 0.0,
        zero: float = 0.0,
    ) -> Identified:
        """Make one of the values of the links `bouc_wen` and `second_order`, by parameter name."""
        chosen = _chosen(bouc_wen.LINK, material) | _chosen(second_order.LINK, mechanics)
        return cls(
            **chosen, voltage_range=voltage_range, dead_time=dead_time, ringing=ringing, zero=zero
        )

    @cached_property
    def a(self) -> float:
        """Alpha d, m/V: how fast h grows from zero."""
        return self.alpha * self.d

    @cached_property
    def compliance(self) -> float:
        """k / (k + k_s): displacement per free displacement d u - h, at rest."""
        return self.k / (self.k + self.k_s)

    @cached_property
    def gain(self) -> float:
        """K = d k / (k + k_s), m/V: displacement per volt without hysteresis, at rest.

        With h growing along with the voltage (alpha > 0) the plant's own gain lies below it.
        """
        return self.d * self.compliance

    def reach(self, low: float, high: float) -> tuple[float, float]:
        """Smallest and largest displacement, m, in cycling between two voltages, V, from rest.

        From the first rise to the settled cycle. Not all of it can be reached at every moment:
        after the first cycle a piezo no longer returns to zero. Raises MicrogripperError for values
        whose hysteresis grows beyond all bounds on the way.
        """
        u, h = 0.0, 0.0
        start = min(max(0.0, low), high)
        reached = []
        for goal in (start, *(low, high) * CYCLES_TO_SETTLE, *(high, low) * CYCLES_TO_SETTLE):
            h = advance(h, goal - u, self.a, self.beta, self.gamma, self.n)
            u = goal
            reached.append(self.compliance * (self.d * u - h))
        if not all(map(math.isfinite, reached)):
            raise MicrogripperError(
                f"identified: bouc_wen: beta = {self.beta:g}, gamma = {self.gamma:g}: the "
                f"hysteresis grows beyond all bounds within {low:g} .. {high:g} V"
            )
        return min(reached), max(reached)


def _chosen(link: Link, values: Mapping[str, float]) -> dict[str, float]:
    try:
        return {parameter.name: float(values[parameter.name]) for parameter in link.parameters}
    except KeyError as missing:
        raise MicrogripperError(f"identified: {link.name}: {missing.args[0]} is missing") from None
