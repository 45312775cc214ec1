"""The equivalent linear hysteresis of the paper, equation (7), and its inverse.

    h' = k1 u' + k2 h

Over one held step of T seconds u jumps, h follows by k1 times the jump, and then decays:

    h[k] = exp(k2 T) (h[k-1] + k1 (u[k] - u[k-1])),        u[-1] = h[-1] = 0.

A piezo's hysteresis does not depend on the rate, this one does: k2 fits one drive frequency.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from microgripper_control.control.identified import Identified
from microgripper_control.core.signals import Array


@dataclass(frozen=True)
class Linearised:
    """The coefficients of equation (7)."""

    k1: float  # m/V
    k2: float  # 1/s

    def hysteresis(self, voltage: Array, sample_period: float) -> Array:
        """h (m) at the end of each held step of a voltage (V), shape (n,), from rest; eq. (7)."""
        decay = math.exp(self.k2 * sample_period)
        jumps = np.diff(voltage, prepend=0.0)
        return np.asarray(lfilter([decay * self.k1], [1.0, -decay], jumps))

    def displacement(self, identified: Identified, voltage: Array, sample_period: float) -> Array:
        """x (m) at the end of each held step, equations (4) and (7) with the mechanics at rest.

        x = k/(k + k_s) (d u - h); only d, k and k_s of the identified values are used.
        """
        h = self.hysteresis(voltage, sample_period)
        return identified.compliance * (identified.d * voltage - h)

    def voltage(self, identified: Identified, displacement: Array, sample_period: float) -> Array:
        """u (V) of each held step that ends at a wanted displacement (m), both of shape (n,).

        `displacement` solved for u, step by step: with w = (k + k_s)/k x,

            u[k] = (w[k] + exp(k2 T) (h[k-1] - k1 u[k-1])) / (d - exp(k2 T) k1).
        """
        free = displacement / identified.compliance
        decay = math.exp(self.k2 * sample_period)
        steepness = identified.d - decay * self.k1
        result = np.empty(len(free))
        u = h = 0.0
        for k, wanted in enumerate(free):
            new = (wanted + decay * (h - self.k1 * u)) / steepness
            h = decay * (h + self.k1 * (new - u))
            u = result[k] = new
        return result
