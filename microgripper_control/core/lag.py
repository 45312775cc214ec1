"""Exact steps of a linear lag of second order, down to first order at a vanishing coefficient.

    a2 y'' + a1 y' + y = u

With u held or running straight, y runs towards a line of its own, and the distance from that line
decays freely. The free decay is a closed form in the poles that stays accurate where the two meet,
where they are complex and where one of them is so fast that first order is left.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.signals import Array, Timing

SMALLEST_A2 = 1e-12  # of a1^2: the faster lag is then nothing to the slower one
SHORTEST = 1e-100  # s: of a shorter lag there is no square to divide by
FIRST_ORDER = 0.02  # of a2 / a1^2: what is below counts as first order


def _free_decay(a1: float, a2: float, step: float) -> tuple[float, float, float, float]:
    """Matrix of (y, y') over a step, s, at u = 0, row by row."""
    middle = a1 / (2.0 * a2)
    apart = np.sqrt(complex(a1 * a1 - 4.0 * a2)) / (2.0 * a2)
    slow = np.exp(-step / (a2 * (middle + apart)))  # its pole without a difference of large numbers
    share = slow * (step if apart == 0.0 else -np.expm1(-2.0 * apart * step) / (2.0 * apart))
    mean = slow * (1.0 + np.exp(-2.0 * apart * step)) / 2.0
    c, s = float(mean.real), float(share.real)
    return c + middle * s, s, -s / a2, c - middle * s


def lag_rows(a1: float, a2: float, timing: Timing) -> Array:
    """Coefficients of `advance_lag` for each step of a sample period, shape (steps, 7).

    `a1` in s, `a2` in s^2. Without any lag, if both vanish, they are zeros, which give y = u.
    """
    if a1 < SHORTEST and a2 < SHORTEST**2:
        return np.zeros((len(timing.steps), 7))
    a2 = max(a2, SMALLEST_A2 * a1 * a1)
    rows = []
    for step in timing.steps:
        course = (1.0, 1.0 / step, a1 / step) if timing.ramped else (0.0, 0.0, 0.0)
        rows.append((*_free_decay(a1, a2, step), *course))
    return np.array(rows)


def order(curvature: float) -> str:
    """What a lag with a2 = curvature a1^2 is called."""
    return "first" if curvature < FIRST_ORDER else "second"


@compiled
def advance_lag(c: Array, y: float, v: float, old: float, new: float) -> tuple[float, float]:
    """Return y and v = y' after a step over which u went from `old` to `new`; c from `lag_rows`."""
    rise = new - old
    end = new - c[6] * rise  # of the line that y runs towards
    begin, slope = end - c[4] * rise, c[5] * rise
    y, v = y - begin, v - slope
    return end + c[0] * y + c[1] * v, slope + c[2] * y + c[3] * v
