"""How far identified numbers can be trusted.

A least-squares estimate is a weighted sum of the readings, by the rows of (J'J)^-1 J'. With
independent residuals of one size its variance is s^2 (J'J)^-1; but recordings differ in their
noise, and what tells a number may be the noisy one. So each recording counts with its own s,

    (J'J)^-1 (sum over recordings of s_r^2 tau_r J_r'J_r) (J'J)^-1,

the sandwich of Eicker, Huber and White (White 1980) with one noise for each group. Where the model
leaves structure in the residual, neighbouring samples are not independent: tau_r is the residual's
integrated autocorrelation time, so that n correlated samples count as n / tau independent ones
(summed in pairs until one is negative, after Geyer 1992). How many degrees of freedom such a sum of
variances has is Satterthwaite's (1946) answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True)
class Spread:
    """How far estimates scatter: variances and their degrees of freedom, each of shape (p,).

    A variance is in the squared unit of its estimate, and infinite where the data see nothing.
    """

    variances: Array
    freedom: Array


def spread_of(jacobian: Array, residuals: Sequence[Array], offsets: Sequence[int]) -> Spread:
    """The spread of the estimates whose Jacobian, shape (samples, p), is given.

    `residuals` holds one array per recording, `offsets` how many values of its own were eliminated
    from each before.
    """
    weights, seen = _weights(jacobian)
    ends = np.cumsum([len(residual) for residual in residuals])[:-1]
    parts = list(zip(np.split(jacobian, ends), np.split(weights, ends), strict=True))
    fitted = np.array([np.sum(rows * share) for rows, share in parts]) + np.array(offsets)
    lengths = np.array([len(residual) for residual in residuals], float)
    times = np.array([autocorrelation_time(residual) for residual in residuals])
    squares = np.array([float(residual @ residual) for residual in residuals]) * times
    left = np.maximum(lengths - fitted, 0.0)
    # What is left of a short recording may be nothing: the mean noise counts as one more sample.
    noise = (squares + np.sum(squares) / max(1.0, float(np.sum(left)))) / (left + 1.0)
    shares = noise[:, None] * np.array([np.sum(share**2, axis=0) for _, share in parts])
    independent = np.maximum(lengths / times - fitted, 1.0)
    variances = np.sum(shares, axis=0)
    scatter = np.sum(shares**2 / independent[:, None], axis=0)
    known = scatter > 0.0
    freedom = np.full(len(variances), float(np.sum(independent)))
    freedom[known] = variances[known] ** 2 / scatter[known]
    return Spread(np.where(seen, variances, np.inf), freedom)


def _weights(jacobian: Array) -> tuple[Array, NDArray[np.bool_]]:
    """With what weight each sample enters each estimate, and whether the data see that at all.

    Shapes (samples, p) and (p,); the weights are the pseudoinverse of the Jacobian, transposed.
    """
    norms = np.linalg.norm(jacobian, axis=0)
    moving = norms > 0.0
    weights, seen = np.zeros_like(jacobian), moving.copy()
    if moving.any():
        left, sizes, directions = np.linalg.svd(
            jacobian[:, moving] / norms[moving], full_matrices=False
        )
        kept = sizes > 1e-12 * sizes[0]
        scaled = left[:, kept] @ (directions[kept] / sizes[kept, None])
        weights[:, moving] = scaled / norms[moving]
        seen[moving] = np.all(directions[~kept] == 0.0, axis=0)
    return weights, seen


def interval(value: float, variance: float, freedom: float) -> tuple[float, float]:
    """The two-sided 95 % interval around a value; `freedom` independent samples are left over."""
    from scipy.special import stdtrit  # takes 0.03 s to import: not for a node

    half = float(stdtrit(max(1.0, freedom), 0.5 + LEVEL / 2.0)) * float(np.sqrt(variance))
    return value - half, value + half
