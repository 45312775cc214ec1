"""The nominal chain as one would script it: rates for a general integrator, and a plain loop.

The state is (h, x, x'/omega), all in um, so that one atol fits all three; the voltage runs
straight from sample to sample (`--hold first`), because an integrator needs its slope.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import odeint, solve_ivp

from microgripper_control.core.signals import Array

UM = 1e6  # um per m

Values = Mapping[str, float]


@dataclass(frozen=True)
class Script:
    """One rig's parameters by name (d, alpha, beta, gamma, m, b, k, k_s) and one voltage, V."""

    values: Values
    voltage: Array
    sample_period: float  # s

    @property
    def _time(self) -> Array:
        return self.sample_period * np.arange(len(self.voltage), dtype=np.float64)

    def _start(self) -> list[float]:
        """At rest at a first voltage of 0 V."""
        return [0.0, 0.0, 0.0]

    def rates(self) -> _Rates:
        """The right side of the differential equations."""
        return _Rates(self.values, self.voltage.tolist(), self.sample_period)

    def solve_ivp(self, method: str, rtol: float, atol: float) -> Array:
        """Displacement, m, by `scipy.integrate.solve_ivp`, NaN if it fails; `atol` is in um."""
        time = self._time
        solved = solve_ivp(
            self.rates(),
            (time[0], time[-1]),
            self._start(),
            method=method,
            t_eval=time,
            rtol=rtol,
            atol=atol,
            max_step=self.sample_period,  # without it a step may pass over a whole corner
        )
        return np.asarray(solved.y[1]) / UM if solved.success else np.full(len(time), np.nan)

    def odeint(self, rtol: float, atol: float) -> Array:
        """Displacement, m, by `scipy.integrate.odeint`; `atol` is in um."""
        solved = odeint(
            self.rates(),
            self._start(),
            self._time,
            tfirst=True,
            rtol=rtol,
            atol=atol,
            hmax=self.sample_period,
        )
        return np.asarray(solved[:, 1]) / UM


class _Rates:
    """Equations (2) to (4) in plain floats, which are quicker than arrays of three."""

    def __init__(self, values: Values, voltage: Sequence[float], period: float) -> None:
        self._d, self._a = UM * values["d"], UM * values["alpha"] * values["d"]
        self._beta, self._gamma = values["beta"], values["gamma"]
        stiffness = values["k"] + values["k_s"]
        self._omega = math.sqrt(stiffness / values["m"])
        self._damping = values["b"] / (values["m"] * self._omega)
        self._gain = values["k"] / stiffness
        self._voltage, self._per = voltage, 1.0 / period
        self._last = len(voltage) - 2

    def __call__(self, time: float, state: Sequence[float]) -> tuple[float, float, float]:
        h, x, v = state
        at = time * self._per
        k = min(max(int(at), 0), self._last)
        rise = self._voltage[k + 1] - self._voltage[k]
        u, slope = self._voltage[k] + (at - k) * rise, rise * self._per
        w = self._d * u - h
        return (
            self._a * slope - self._beta * abs(slope) * h - self._gamma * slope * abs(h),
            self._omega * v,
            self._omega * (self._gain * w - x - self._damping * v),
        )


def numpy_loop(values: Values, step: Array, voltage: Array) -> Array:
    """Displacement, m, for a held voltage, by a loop over the samples with numpy's functions.

    `step` is the mechanics' difference equation for a sample period, shape (5,).
    """
    a = values["alpha"] * values["d"]
    h, u, latest = 0.0, 0.0, np.zeros(5)  # two positions, then three of the free displacement
    displacement = np.empty(len(voltage))
    for k in range(len(voltage)):
        displacement[k] = latest[0]
        h = _hysteresis(h, voltage[k] - u, a, values["beta"], values["gamma"])
        u = voltage[k]
        latest[3:] = latest[2:-1]
        latest[2] = values["d"] * u - h
        latest[:2] = step @ latest, latest[0]
    return displacement


def _hysteresis(h: float, du: float, a: float, beta: float, gamma: float) -> float:
    """h after the voltage moved by du, m: equations (2) and (3) solved for n = 1."""
    sign, xi = np.sign(du), np.abs(du)
    g = sign * h
    if g < 0.0:
        c = beta - gamma
        end = g - (a - c * g) * np.expm1(-c * xi) / c
        if end <= 0.0:
            return float(sign * end)
        g, xi = 0.0, xi - np.log1p(-c * g / a) / c
    c = beta + gamma
    return float(sign * (g - (a - c * g) * np.expm1(-c * xi) / c)) if du else h
