"""The rig without any effect: its numbers, and the scales that its effects are measured in.

Two actuators, each in the ranges of voltage a laboratory would use: the paper's (Table 1), and one
after the maker's data of the APA120S (140 um over 170 V, 1.3 kHz, 0.33 N/um), whose resonance
shows in a recording.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.validation.hysteresis import free_course

FITTED = ("d", "alpha", "beta", "gamma", "m", "b")  # k and k_s show only through these
MISTUNED = (*FITTED, "k", "k_s")


@dataclass(frozen=True)
class Base:
    """Parameters of the paper's equations (1) to (4) with n = 1, SI units."""

    d: float = 1.4447e-7  # m/V
    alpha: float = 0.0801
    beta: float = 0.0152  # 1/V
    gamma: float = -0.0227  # 1/V
    m: float = 0.0038  # kg
    b: float = 150.0  # N s/m
    k: float = 5.0e7  # N/m
    k_s: float = 8.2e5  # N/m

    @property
    def stiffness(self) -> float:
        """Of stack and flexure together, N/m."""
        return self.k + self.k_s

    @property
    def natural_frequency(self) -> float:
        """Undamped, rad/s."""
        return math.sqrt(self.stiffness / self.m)

    @property
    def hysteresis(self) -> tuple[float, float, float, float]:
        """d, alpha, beta, gamma."""
        return self.d, self.alpha, self.beta, self.gamma

    def scaled(self, factors: dict[str, float]) -> Base:
        """The base with some parameters multiplied."""
        return replace(self, **{name: getattr(self, name) * by for name, by in factors.items()})

    def equivalent(self, other: Base) -> Base:
        """The base that moves just so with the stiffnesses of another, which do not show."""
        softer = other.stiffness / self.stiffness
        gain = (self.k / self.stiffness) / (other.k / other.stiffness)
        return replace(
            self,
            d=self.d * gain,
            m=self.m * softer,
            b=self.b * softer,
            k=other.k,
            k_s=other.k_s,
        )

    def course(self, voltage: list[float]) -> list[float]:
        """Displacement at rest after each of these voltages, gone through from 0 V, m."""
        free = free_course(self.hysteresis, np.array(voltage))
        return [float(w) * self.k / self.stiffness for w in free]


@dataclass(frozen=True)
class Actuator:
    """A base with its nominal numbers, as the user's model has them, and a range of voltage, V.

    `slowest` is the lowest sampling rate, Hz, at which it makes sense to drive it: a resonance that
    rings on over many samples and turns many times in each cannot be told from its aliases.
    """

    name: str
    base: Base
    low: float
    high: float
    slowest: float

    @property
    def scale(self) -> Scale:
        """The scales of the nominal actuator."""
        bottom, top = self.base.course([self.high, self.low, self.high])[1:]
        return Scale(self.low, self.high, min(bottom, 0.0), top, self.base)


@dataclass(frozen=True)
class Scale:
    """What effects are measured in; that of the nominal actuator, the same for rig and oracle."""

    low: float  # V
    high: float  # V
    bottom: float  # m, displacement at `low`
    top: float  # m, displacement at `high`
    base: Base

    @property
    def span(self) -> float:
        """Range of the voltage, V."""
        return self.high - self.low

    @property
    def stroke(self) -> float:
        """Range of the displacement, m."""
        return self.top - self.bottom

    @property
    def force(self) -> float:
        """What holds the actuator back by its whole stroke, N."""
        return self.base.stiffness * self.stroke

    def displacement(self, share: float) -> float:
        """The displacement at a share of the stroke, m."""
        return self.bottom + share * self.stroke


PAPER = Base()
# 0.33 N/um in all, of which the flexure has a sixth; 1.3 kHz; 3 % damping; 140 um over 170 V.
DATASHEET = Base(d=1.16e-6, m=0.00495, b=2.43, k=2.8e5, k_s=5.0e4)

ACTUATORS = (
    Actuator("APA120S", PAPER, 0.0, 160.0, 200.0),
    Actuator("APA120S bipolar", PAPER, -80.0, 80.0, 200.0),
    Actuator("APA120S datasheet", DATASHEET, -20.0, 150.0, 1000.0),
)
