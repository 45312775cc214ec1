"""How far identified numbers can be trusted.

The covariance of a least-squares estimate is s^2 (J'J)^-1 for independent residuals. Where the
model leaves structure in the residual, neighbouring samples are not independent: the variance is
then multiplied by the residual's integrated autocorrelation time, so that n correlated samples
count as n / tau independent ones (summed in pairs until one is negative, after Geyer 1992).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import Array

LEVEL = 0.95
NORMAL_MEDIAN = 0.6744897501960817  # of |x|, x standard normal


def autocorrelation_time(residual: Array) -> float:
    """Integrated autocorrelation time of a residual, samples, at least 1."""
    centred = residual - residual.mean()
    size = 1 << (2 * len(centred) - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(centred, size)) ** 2
    covariance = np.fft.irfft(spectrum, size)[: len(centred)]
    if covariance[0] <= 0.0:
        return 1.0
    rho = covariance / covariance[0]
    pairs = rho[1 : len(rho) // 2 * 2 - 1 : 2] + rho[2 : len(rho) // 2 * 2 : 2]
    negative = np.flatnonzero(pairs <= 0.0)
    end = negative[0] if len(negative) else len(pairs)
    return float(max(1.0, 1.0 + 2.0 * np.sum(pairs[:end])))


def independent_samples(residuals: Sequence[Array]) -> float:
    """How many independent samples correlated residuals amount to."""
    return float(sum(len(residual) / autocorrelation_time(residual) for residual in residuals))


def white_noise(residual: Array) -> float:
    """Standard deviation of the white part of a residual, in its unit.

    Second differences remove whatever runs smoothly from sample to sample and leave white noise
    with six times its variance; their median size overlooks single jumps.
    """
    return float(np.median(np.abs(np.diff(residual, 2))) / (NORMAL_MEDIAN * np.sqrt(6.0)))


def variances_of(jacobian: Array, residuals: Sequence[Array], offsets: int) -> Array:
    """Variances of the estimates, shape (p,), in the squared units of the Jacobian's columns.

    `residuals` holds one array per recording, `offsets` counts the parameters eliminated before.
    What the data cannot see gets an infinite variance.
    """
    count = sum(len(r) for r in residuals)
    freedom = max(1, count - jacobian.shape[1] - offsets)
    squares = sum(float(r @ r) * autocorrelation_time(r) for r in residuals)
    norms = np.linalg.norm(jacobian, axis=0)
    seen = norms > 0.0
    result = np.full(len(norms), np.inf)
    if seen.any():
        scaled = jacobian[:, seen] / norms[seen]
        _, sizes, directions = np.linalg.svd(scaled, full_matrices=False)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = np.where(sizes > 1e-12 * sizes[0], 1.0 / sizes**2, np.inf)
            parts = np.where(directions == 0.0, 0.0, directions**2 * inverse[:, None])
        result[seen] = parts.sum(axis=0) / norms[seen] ** 2 * squares / freedom
    return result


def interval(value: float, variance: float, freedom: float) -> tuple[float, float]:
    """The two-sided 95 % interval around a value; `freedom` independent samples are left over."""
    from scipy.special import stdtrit  # takes 0.03 s to import: not for a node

    half = float(stdtrit(max(1.0, freedom), 0.5 + LEVEL / 2.0)) * float(np.sqrt(variance))
    return value - half, value + half
