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


def _free_decay(a1: float, a2: float, steps: Array) -> tuple[Array, Array, Array, Array]:
    """Matrix of (y, y') over steps, s, at u = 0: its four entries, shape (steps,) each."""
    middle = a1 / (2.0 * a2)
    apart = np.sqrt(complex(a1 * a1 - 4.0 * a2)) / (2.0 * a2)
    # The slow pole without a difference of large numbers.
    slow = np.exp(-steps / (a2 * (middle + apart)))
    share = slow * (steps if apart == 0.0 else -np.expm1(-2.0 * apart * steps) / (2.0 * apart))
    mean = slow * (1.0 + np.exp(-2.0 * apart * steps)) / 2.0
    c, s = mean.real, share.real
    return c + middle * s, s, -s / a2, c - middle * s


def lag_rows(a1: float, a2: float, timing: Timing) -> Array:
    """Coefficients of `advance_lag` for each step of a sample period, shape (steps, 6).

    `a1` in s, `a2` in s^2. Without any lag, if both vanish, they are zeros, which give y = u.
    """
    if a1 < SHORTEST and a2 < SHORTEST**2:
        return np.zeros((len(timing.steps), 6))
    a2 = max(a2, SMALLEST_A2 * a1 * a1)
    steps = np.array(timing.steps)
    yy, yv, vy, vv = _free_decay(a1, a2, steps)
    course = (-yy, -vy)
    if timing.ramped:  # the line that y runs towards is `late` times u's rise below u
        late, slope = a1 / steps, 1.0 / steps
        course = ((yy - 1.0) * late - yv * slope, vy * late + (1.0 - vv) * slope)
    return np.stack([yy, yv, vy, vv, *course], axis=1)


def order(curvature: float) -> str:
    """What a lag with a2 = curvature a1^2 is called."""
    return "first" if curvature < FIRST_ORDER else "second"


@compiled
def advance_lag(c: Array, away: float, v: float, rise: float) -> tuple[float, float]:
    """Return y - u and v = y' after a step over which u rose by `rise`; c from `lag_rows`.

    The distance from u is what is carried on: at rest it stays 0 to the bit. What is new comes
    last, so that the next step waits for no more than two products.
    """
    return (
        c[0] * away + (c[1] * v + c[4] * rise),
        c[2] * away + (c[3] * v + c[5] * rise),
    )


@compiled
def follow(rows: Array, state: Array, signal: Array, share: float) -> None:
    """Turn a signal u, shape (n,), into u + share (y - u), y its lag; rows from `lag_rows`.

    State: y - u, y', u so far.
    """
    away, v, old = state[0], state[1], state[2]
    row = 0
    for j in range(signal.shape[0]):
        new = signal[j]
        away, v = advance_lag(rows[row], away, v, new - old)
        old = new
        signal[j] = new + share * away
        row = row + 1 if row + 1 < rows.shape[0] else 0
    state[0], state[1], state[2] = away, v, old
