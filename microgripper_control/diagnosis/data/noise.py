"""The noise floor: what of a residual nothing could predict.

The floor is the innovation of the residual, what is new in each sample to whoever knows those
before it. For white sensor noise that is all of it; hum, creep or a wrong model are predictable
from their own past and do not count.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_toeplitz

from microgripper_control.core.signals import Array

ORDER = 16  # samples of the past
STRETCH = 16  # samples over which squares are averaged
USUAL = (1.0 - 2.0 / (9.0 * STRETCH)) ** 3  # the median of so many normal ones, in means


def innovation(errors: Sequence[Array], ahead: int = 1) -> float:
    """Standard deviation, m, of what each sample adds to ORDER samples before it (Yule-Walker).

    The last of these lies `ahead` samples before it. `errors` are stretches of residual, m, without
    gaps; inf if all are too short to tell.
    """
    covariance = np.zeros(ORDER + ahead)
    count = 0
    for error in errors:
        if len(error) <= 2 * len(covariance):
            continue
        covariance += _covariance(error, len(covariance))
        count += len(error)
    if count == 0:
        return np.inf
    if covariance[0] <= 0.0:
        return 0.0
    covariance[0] *= 1.0 + 1e-9
    weights = solve_toeplitz(covariance[:ORDER], covariance[ahead:])
    left = float(covariance[0] - weights @ covariance[ahead:])
    return float(np.sqrt(max(left, 0.0) / max(1, count - ORDER)))


def usual_innovation(error: Array) -> float:
    """As `innovation`, m, of one course of residual, but by the median of short stretches.

    What comes now and then is left out, such as what a lag leaves of each step of the voltage: its
    past does not tell it, but it is no noise. Outliers that come all the time are, and the median
    of single samples would pass them over as well (USUAL: Wilson and Hilferty 1931).
    """
    covariance = _covariance(error, ORDER + 1)
    if covariance[0] <= 0.0:
        return 0.0
    covariance[0] *= 1.0 + 1e-9
    weights = solve_toeplitz(covariance[:-1], covariance[1:])
    new = np.convolve(error, np.append(1.0, -weights), "valid")
    if len(new) < STRETCH:
        return float(np.sqrt(np.mean(new**2)))
    squares = new[: len(new) // STRETCH * STRETCH].reshape(-1, STRETCH) ** 2
    return float(np.sqrt(np.median(squares.mean(axis=1)) / USUAL))


def quietest(errors: Sequence[Array]) -> float:
    """The least `usual_innovation`, m, of stretches of residual; inf if all are too short to tell.

    On a coarse grid readings may often bring nothing new: the noise is no less than rounding then.
    """
    long = [error for error in errors if len(error) > 2 * ORDER]
    return min(map(usual_innovation, long), default=np.inf)


def _covariance(error: Array, count: int) -> Array:
    """Sums of products, m^2, of samples 0 .. count - 1 apart."""
    return np.array([error[lag:] @ error[: len(error) - lag] for lag in range(count)])


def removable(rmse: float, floor: float) -> float:
    """e(r): the part of an error, m, that a better model could take away."""
    return float(np.sqrt(max(rmse**2 - floor**2, 0.0)))
