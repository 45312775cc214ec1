"""Least squares from a point to the bottom of its valley: Levenberg-Marquardt within bounds.

scipy's trust region reflective method measures each parameter by its distance to a bound. Ranges
that differ by ten decades then bend every step that is cut short: on a flexure that stiffens, it
stayed at 420 nm where this one gets to the noise, 15 nm, in eight steps. `dogbox` does not bear
parameters that the data hardly tell apart.

Steps are damped in units of the largest column norms so far (Moré 1978), the more the less of what
was promised a step has gained (Nielsen 1999), and projected on the bounds
(Kanzow, Yamashita and Fukushima 2004); a parameter at a bound it is pressed against stays there.
Derivatives cost as many evaluations as there are parameters. So each are used for some more steps,
corrected by what the last one has shown (Broyden 1965), while these keep what they promise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from microgripper_control.core.signals import Array

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-12, 1e10
MORE, LESS = 2.0, 0.1  # damping after a step that failed, the next ever faster; and at least, else
STUCK = 0.1  # of the tolerance: a step that gains less of the squares is the last
CORRECTED = 2  # steps with corrected derivatives, at most,
KEPT = 0.5  # as long as they gain more than this of what they promise


def descend(
    residuals: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    start: Array,
    bounds: tuple[Array, Array],
    tolerance: float,
    evaluations: int,
) -> tuple[Array, Array, int]:
    """The best point, shape (p,), its residuals, shape (n,), and how many evaluations it took.

    It ends where neither the last step nor the best next one, if the residuals were linear, takes
    away more than `tolerance` of the squares (Bates and Watts 1981). Points where residuals are not
    finite are not gone to; from a `start` like that there is no way. Steps with corrected
    derivatives do not count as evaluations.
    """
    z = np.clip(start, *bounds)
    left, used, damping = residuals(z), 1, FIRST_DAMPING
    squares = float(left @ left)
    sizes = np.zeros(len(z))
    while used < evaluations and np.isfinite(squares):
        slopes, begun = jacobian(z), z
        if not np.all(np.isfinite(slopes)):
            break
        sizes = np.maximum(sizes, np.linalg.norm(slopes, axis=0))
        for correction in range(1 + CORRECTED):
            if (plane := _Plane.about(z, left, slopes, sizes, bounds)) is None:
                break
            tries = 1 if correction else evaluations - used
            step, tried = _downhill(plane, residuals, squares, damping, tries)
            used += 0 if correction else tried
            if step is None:
                break
            gained = squares - step.squares
            kept = gained > KEPT * step.promised
            done = gained <= STUCK * tolerance * squares
            done |= max(gained, plane.possible - gained) <= tolerance * squares
            way, change = step.z - z, step.left - left
            z, left, squares = step.z, step.left, step.squares
            damping = step.next_damping(gained)
            if done and (kept or not correction):
                return z, left, used
            if not kept or correction == CORRECTED:
                break
            slopes = _corrected(slopes, sizes, way, change)
        if z is begun:
            break
    return z, left, used


@dataclass(frozen=True)
class _Step:
    """Where a step led, the residuals there, and what it had been expected to take away."""

    z: Array
    left: Array
    squares: float
    promised: float
    damping: float

    def next_damping(self, gained: float) -> float:
        """Less, the more of what was promised it has gained."""
        less = max(LESS, 1.0 - (2.0 * gained / self.promised - 1.0) ** 3)
        return max(LEAST_DAMPING, less * self.damping)


@dataclass(frozen=True)
class _Plane:
    """The residuals about a point as if they were linear, without parameters at their bounds."""

    z: Array
    free: Array  # of bool, shape (p,)
    sizes: Array  # of the free ones' columns
    factor: Array  # R of their columns, each divided by its size
    rotated: Array  # the residuals in terms of Q
    bounds: tuple[Array, Array]

    @classmethod
    def about(
        cls, z: Array, left: Array, slopes: Array, sizes: Array, bounds: tuple[Array, Array]
    ) -> _Plane | None:
        """None where no parameter is free to go, or corrected derivatives have overflown."""
        (low, high), uphill = bounds, slopes.T @ left
        free = (sizes > 0.0) & ~(((z <= low) & (uphill > 0.0)) | ((z >= high) & (uphill < 0.0)))
        if not np.any(free):
            return None
        table = np.column_stack([slopes[:, free] / sizes[free], left])
        triangle = np.asarray(np.linalg.qr(table, mode="r"))
        if not np.all(np.isfinite(triangle)):
            return None
        count = table.shape[1] - 1
        factor, rotated = triangle[:count, :count], triangle[:count, count]
        return cls(z, free, sizes[free], factor, rotated, bounds)

    @property
    def possible(self) -> float:
        """What the best step would take away of the squares."""
        return float(self.rotated @ self.rotated)

    def step(self, damping: float) -> tuple[Array, float]:
        """Where a damped step leads, and what it takes away of the squares."""
        count = len(self.sizes)
        damped = np.vstack([self.factor, np.sqrt(damping) * np.eye(count)])
        step = np.linalg.lstsq(damped, np.append(-self.rotated, np.zeros(count)), rcond=None)[0]
        tried = self.z.copy()
        tried[self.free] += step / self.sizes
        missed = self.factor @ step + self.rotated
        return np.clip(tried, *self.bounds), self.possible - float(missed @ missed)


def _downhill(
    plane: _Plane,
    residuals: Callable[[Array], Array],
    squares: float,
    damping: float,
    tries: int,
) -> tuple[_Step | None, int]:
    """The first step that gains, damped more and more; and how many of so many were tried."""
    more, tried = MORE, 0
    while tried < tries and damping < MOST_DAMPING:
        z, promised = plane.step(damping)
        left = residuals(z)
        tried, after = tried + 1, float(left @ left)
        if after < squares:
            return _Step(z, left, after, promised, damping), tried
        damping, more = more * damping, 2.0 * more
    return None, tried


def _corrected(slopes: Array, sizes: Array, way: Array, change: Array) -> Array:
    """Derivatives that are right along the last step; `sizes` is what its length is measured in."""
    scaled = sizes * way
    return slopes + np.outer(change - slopes @ way, sizes * scaled / float(scaled @ scaled))
