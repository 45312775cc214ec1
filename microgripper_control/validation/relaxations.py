"""Responses without a time constant of their own, as integrals over relaxation rates.

A response that grows as J(t) after a unit step is written (Montseny, ESAIM Proc. 5, 1998)

    J(t) = integral of M(r) (1 - exp(-r t)) d ln r

and summed over rates three to a decade. For smooth M the sum is the integral to 1e-5, because the
trapezoidal rule converges exponentially; the span of rates reaches far beyond every recording.
"""

from __future__ import annotations

from math import gamma, log

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array

SLOWEST, FASTEST = 1e-6, 1e5  # 1/s
A_DECADE = 3


def rates() -> Array:
    """The rates of relaxation, 1/s."""
    decades = np.log10(FASTEST / SLOWEST)
    return np.geomspace(SLOWEST, FASTEST, int(A_DECADE * decades) + 1)


def logarithmic(onset: float) -> Array:
    """Weights for J(t) = ln(1 + t / onset): M(r) = exp(-r onset)."""
    return np.exp(-rates() * onset) * log(10.0) / A_DECADE


def power_law(order: float) -> Array:
    """Weights for J(t) = t^order (t in s, 0 < order < 1): M(r) = order / Gamma(1 - order) r^-order.

    Beyond the fastest rate the response counts as instant and is left out.
    """
    return order / gamma(1.0 - order) * rates() ** -order * log(10.0) / A_DECADE


@compiled
def march_relaxations(
    gain: Array, weights: Array, state: Array, drive: Array, response: Array
) -> None:
    """Add the response to `drive` held over each step; `gain` is 1 - exp(-rate step)."""
    for j in range(len(drive)):
        total = 0.0
        for i in range(len(gain)):
            state[i] += gain[i] * (drive[j] - state[i])
            total += weights[i] * state[i]
        response[j] += total


def gains(step: float) -> Array:
    """1 - exp(-rate step) for each rate."""
    return -np.expm1(-rates() * step)
