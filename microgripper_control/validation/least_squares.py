"""Levenberg's and Marquardt's method within bounds, for long residuals and few numbers.

Normal equations suffice: the numbers are scaled near one, and a direction that the data do not see
is held by the damping instead of running off to a bound.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from microgripper_control.validation.block import Array

FLOOR = 1e-7  # of the largest diagonal entry: what damps a direction that shows nothing
GENTLEST, STRONGEST = 1e-6, 1e6


def minimise(
    residual: Callable[[Array], Array],
    jacobian: Callable[[Array, Array], Array],
    begin: Array,
    low: Array,
    high: Array,
    iterations: int,
    enough: float,
) -> Array:
    """Return where the sum of squares is least; `jacobian(z, residual at z)`.

    It stops where the sum falls by less than the share `enough`.
    """
    z = np.clip(begin, low, high)
    r = residual(z)
    cost = float(r @ r)
    damping = 1e-3
    for _ in range(iterations):
        j = jacobian(z, r)
        normal, gradient = j.T @ j, j.T @ r
        weights = np.diag(normal) + FLOOR * max(np.diag(normal).max(), 1e-300)
        before = cost
        while damping <= STRONGEST:
            # A number at its bound that wants beyond is left out.
            stuck = ((z <= low) & (gradient > 0.0)) | ((z >= high) & (gradient < 0.0))
            system = normal + np.diag(damping * weights)
            system[stuck, :] = 0.0
            system[stuck, stuck] = 1.0
            step = np.linalg.solve(system, np.where(stuck, 0.0, -gradient))
            trial = np.clip(z + step, low, high)
            moved = residual(trial)
            if float(moved @ moved) < cost:
                z, r, cost = trial, moved, float(moved @ moved)
                damping = max(0.1 * damping, GENTLEST)
                break
            damping *= 10.0
        if before - cost <= enough * before:
            break
    return z
