"""The mechanics, equation (4), with forces that push back inside the solve.

    m x'' + b x' + (k + k_s) x = k w + F(x, v, ...)

The linear part is exact (ten steps would not resolve its 18 kHz otherwise). F runs straight over a
step, and its value at the end of the step is the root of one scalar equation, found by the secant
method. So the scheme is implicit in F, and stable while sqrt(stiffness of F / m) times the step is
below sqrt(12): the strongest effects are bounded so that on the grid of 100 kHz it is.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.base import Base
from microgripper_control.validation.block import Array
from microgripper_control.validation.forces import FORCE_NUMBERS, FORCE_STATES, total_force
from microgripper_control.validation.linear import ExactStep, exact_step

MOST_SECANTS = 20
FLATTEST = -0.1  # slope; the push falls by one newton for each of F, less what a softening gives
TOLERANCE = 1e-8  # of k times the scale's stroke


@compiled
def march_free(
    decay: Array, held: Array, ramp: Array, slant: Array, state: Array, push: Array
) -> None:
    """Replace the push k w (N) by x (m) in place; `state` is x, v, last push."""
    x, v, g0 = state[0], state[1], state[2]
    for j in range(len(push)):
        g1 = push[j]
        begin = g1 - slant[j] * (g1 - g0)
        rise = g1 - begin
        xn = decay[0, 0] * x + decay[0, 1] * v + held[0] * begin + ramp[0] * rise
        v = decay[1, 0] * x + decay[1, 1] * v + held[1] * begin + ramp[1] * rise
        x = xn
        g0 = g1
        push[j] = x
    state[0], state[1], state[2] = x, v, g0


@compiled
def march_forced(
    decay: Array,
    held: Array,
    ramp: Array,
    slant: Array,
    state: Array,
    push: Array,
    kinds: Array,
    numbers: Array,
    old: Array,
    new: Array,
    step: float,
    tolerance: float,
) -> None:
    """As `march_free` with forces; `state` is x, v, last push, last F, slope of the last secant.

    Adds to x what each force carries beyond it (the first entry of its state).
    """
    x, v, g0, f0, slope = state[0], state[1], state[2], state[3], state[4]
    for j in range(len(push)):
        g1 = push[j]
        begin = g1 - slant[j] * (g1 - g0)
        rise = g1 - begin
        xl = decay[0, 0] * x + decay[0, 1] * v + held[0] * (begin + f0) + ramp[0] * rise
        vl = decay[1, 0] * x + decay[1, 1] * v + held[1] * (begin + f0) + ramp[1] * rise
        f, f_before, miss_before = f0, f0, 0.0
        for attempt in range(MOST_SECANTS):
            x1 = xl + ramp[0] * (f - f0)
            v1 = vl + ramp[1] * (f - f0)
            miss = total_force(kinds, numbers, old, new, x, v, x1, v1, step) - f
            if abs(miss) <= tolerance:
                break
            if attempt > 0 and miss != miss_before:
                slope = min((miss - miss_before) / (f - f_before), FLATTEST)
            f_before, miss_before = f, miss
            f -= miss / slope
        x, v, g0, f0 = x1, v1, g1, f
        old[:] = new
        push[j] = x + old[:, 0].sum()
    state[0], state[1], state[2], state[3], state[4] = x, v, g0, f0, slope


@lru_cache(maxsize=256)
def _mechanics(stiffness: float, b: float, m: float, step: float) -> ExactStep:
    rates = np.array([[0.0, 1.0], [-stiffness / m, -b / m]])
    return exact_step(rates, np.array([0.0, 1.0 / m]), step)


class Oscillator:
    """Moves with what it is pushed by; begins at rest at zero."""

    def __init__(
        self, base: Base, forces: list[tuple[int, Array]], step: float, stroke: float
    ) -> None:
        self._exact = _mechanics(base.stiffness, base.b, base.m, step)
        self._k = base.k
        self._step = step
        self._tolerance = TOLERANCE * base.stiffness * stroke
        self._kinds = np.array([kind for kind, _ in forces], dtype=np.float64)
        self._numbers = np.zeros((len(forces), FORCE_NUMBERS))
        for row, (_, numbers) in zip(self._numbers, forces, strict=True):
            row[: len(numbers)] = numbers
        self._old = np.zeros((len(forces), FORCE_STATES))
        self._new = np.zeros_like(self._old)
        self._state = np.array([0.0, 0.0, 0.0, 0.0, -1.0])

    def run(self, free: Array, slant: Array) -> None:
        """Replace w (m), which goes to each value as `slant` says, by the displacement (m)."""
        free *= self._k
        s = self._exact
        if len(self._kinds) == 0:
            march_free(s.decay, s.held, s.ramp, slant, self._state, free)
            return
        march_forced(
            s.decay,
            s.held,
            s.ramp,
            slant,
            self._state,
            free,
            self._kinds,
            self._numbers,
            self._old,
            self._new,
            self._step,
            self._tolerance,
        )
