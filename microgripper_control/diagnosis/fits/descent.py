"""Least squares from a point to the bottom of its valley: Levenberg-Marquardt within bounds.

scipy's trust region reflective method measures each parameter by its distance to a bound. Ranges
that differ by ten decades then bend every step that is cut short: on a flexure that stiffens, it
stayed at 420 nm where this one gets to the noise, 15 nm, in eight steps. `dogbox` does not bear
parameters that the data hardly tell apart.

Steps are damped in units of the largest column norms so far (Moré 1978), the more the less of what
was promised a step has gained (Nielsen 1999), and projected on the bounds
(Kanzow, Yamashita and Fukushima 2004); a parameter at a bound it is pressed against stays there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from microgripper_control.core.signals import Array

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-12, 1e10
MORE, LESS = 2.0, 0.1  # damping after a step that failed, the next ever faster; and at least, else
STUCK = 0.1  # of the tolerance: a step that gains less of the squares is the last


def descend(
    residuals: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    start: Array,
    bounds: tuple[Array, Array],
    tolerance: float,
    evaluations: int,
) -> tuple[Array, Array, int]:
    """The best point, shape (p,), its residuals, shape (n,), and how many were evaluated.

    It ends where neither the last step nor the best next one, if the residuals were linear, takes
    away more than `tolerance` of the squares (Bates and Watts 1981). Points where residuals are not
    finite are not gone to; from a `start` like that there is no way.
    """
    low, high = bounds
    z = np.clip(start, low, high)
    left, used, damping, more = residuals(z), 1, FIRST_DAMPING, MORE
    squares = float(left @ left)
    sizes = np.zeros(len(z))
    while used < evaluations and np.isfinite(squares):
        slopes = jacobian(z)
        if not np.all(np.isfinite(slopes)):
            break
        sizes = np.maximum(sizes, np.linalg.norm(slopes, axis=0))
        uphill = slopes.T @ left
        free = (sizes > 0.0) & ~(((z <= low) & (uphill > 0.0)) | ((z >= high) & (uphill < 0.0)))
        count = int(np.count_nonzero(free))
        if count == 0:
            break
        table = np.column_stack([slopes[:, free] / sizes[free], left])
        triangle = np.asarray(np.linalg.qr(table, mode="r"))
        factor, rotated = triangle[:count, :count], triangle[:count, count]
        gained = promised = 0.0
        while used < evaluations and damping < MOST_DAMPING:
            damped = np.vstack([factor, np.sqrt(damping) * np.eye(count)])
            step = np.linalg.lstsq(damped, np.append(-rotated, np.zeros(count)), rcond=None)[0]
            tried = z.copy()
            tried[free] += step / sizes[free]
            tried = np.clip(tried, low, high)
            other = residuals(tried)
            used += 1
            gained = squares - float(other @ other)
            promised = float(rotated @ rotated - np.sum((factor @ step + rotated) ** 2))
            if gained > 0.0:
                break
            damping, more = more * damping, 2.0 * more
        if not gained > 0.0:
            break
        damping = damping * max(LESS, 1.0 - (2.0 * gained / promised - 1.0) ** 3)
        damping, more = max(damping, LEAST_DAMPING), MORE
        z, left = tried, other
        possible = float(rotated @ rotated) - gained
        done = gained <= STUCK * tolerance * squares
        done |= max(gained, possible) <= tolerance * squares
        squares = float(left @ left)
        if done:
            break
    return z, left, used
