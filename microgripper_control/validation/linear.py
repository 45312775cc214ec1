"""Linear systems marched exactly on a uniform grid.

    z' = A z + B u,   y = C z + D u

The step is the matrix exponential of the system with the input's own course appended (Van Loan,
IEEE Trans. Autom. Control 23, 1978), so that a fast pole costs neither accuracy nor stability.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array

System = tuple[Array, Array, Array, float]  # A (n, n), B (n,), C (n,), D


@dataclass(frozen=True)
class ExactStep:
    """z1 = decay z + held u0 + ramp (u1 - u0), for u straight from u0 to u1 over the step."""

    decay: Array  # shape (n, n)
    held: Array  # shape (n,)
    ramp: Array  # shape (n,)


def exact_step(a: Array, b: Array, step: float) -> ExactStep:
    """The step of A (n, n) and B (n,) over `step` seconds."""
    n = len(b)
    course = np.zeros((n + 2, n + 2))
    course[:n, :n] = a * step
    course[:n, n] = b * step
    course[n, n + 1] = 1.0
    whole = expm(course)
    return ExactStep(
        np.ascontiguousarray(whole[:n, :n]), whole[:n, n].copy(), whole[:n, n + 1].copy()
    )


@compiled
def march_linear(
    decay: Array,
    held: Array,
    ramp: Array,
    c: Array,
    through: float,
    state: Array,
    last: Array,
    slant: Array,
    signal: Array,
) -> None:
    """Replace u by y in place; `state` is z and `last` holds the last u."""
    n = len(held)
    new = np.empty(n)
    u0 = last[0]
    for j in range(len(signal)):
        u1 = signal[j]
        begin = u1 - slant[j] * (u1 - u0)
        y = through * u1
        for i in range(n):
            value = held[i] * begin + ramp[i] * (u1 - begin)
            for m in range(n):
                value += decay[i, m] * state[m]
            new[i] = value
            y += c[i] * value
        state[:] = new
        signal[j] = y
        u0 = u1
    last[0] = u0


class LinearFilter:
    """A filter that begins at rest at zero and works on a signal in place."""

    def __init__(self, system: System, step: float) -> None:
        a, b, self._c, self._through = system
        self._exact = exact_step(a, b, step)
        self._state, self._last = np.zeros(len(b)), np.zeros(1)

    def run(self, signal: Array, slant: Array) -> None:
        """Filter a signal that goes to each value as `slant` says (see Block)."""
        s = self._exact
        state, last = self._state, self._last
        march_linear(s.decay, s.held, s.ramp, self._c, self._through, state, last, slant, signal)


def slant_after_jump(system: System, step: float) -> float:
    """How the output gets to its value by the end of the step in which the input has jumped."""
    a, b, c, through = system
    n = len(b)
    longer = np.zeros((n + 1, n + 1))  # with the output's integral, which gives its mean
    longer[:n, :n], longer[n, :n] = a, c
    reached = exact_step(longer, np.append(b, through), step).held
    end = float(c @ reached[:n]) + through
    mean = float(reached[n]) / step
    return min(max(2.0 * (end - mean) / end, 0.0), 1.0) if end else 1.0


def state_space(numerator: list[float], denominator: list[float], seconds: float) -> System:
    """A, B, C, D of a ratio of polynomials in p = s * `seconds`, highest power first.

    Both lists have the same length and the denominator begins with 1. In observable form with p
    scaled, so that the numbers stay near one whatever `seconds` is.
    """
    n = len(denominator) - 1
    through = numerator[0]
    a = np.zeros((n, n))
    a[:, 0] = -np.array(denominator[1:])
    a[:-1, 1:] = np.eye(n - 1)
    b = np.array(numerator[1:]) - through * np.array(denominator[1:])
    c = np.zeros(n)
    c[0] = 1.0
    return a / seconds, b / seconds, c, through
