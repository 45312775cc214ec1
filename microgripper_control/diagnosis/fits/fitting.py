"""Base parameters and effects fitted together, from a guess to the least squares.

A gap is small against the stroke, so the derivatives by the base parameters change little when an
effect is added. Where each sample is costly they are taken once, at the refit, and kept while an
effect is fitted (the chord method). Elsewhere all are fresh: a strong effect is not found without.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.descent import descend
from microgripper_control.diagnosis.fits.prior import Prior
from microgripper_control.diagnosis.fits.trial import (
    Trial,
    fitted_keys,
    judged_once,
    problem_of,
    trial_at,
)
from microgripper_control.identification.nuisance import Projection
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Model

ROUGH = 1e-3  # tolerance, relative, of the squares and of the step, where another fit follows
FINE = 1e-6  # the same, of what is reported
EVALUATIONS = 6  # of one start, with the chord method
SEEN = 1e-3  # of the best seen direction of the base parameters: weaker ones stay
MUCH = 0.5  # of the squares: a prior that was weighed by more than twice what is left is too heavy
WAYS = (1.0, 0.5, 0.2)  # shares of the linear step that are tried first

Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Base:
    """An explanation to build on, with the derivatives of its residuals."""

    trial: Trial
    residual: Array  # m, shape (samples,), what is left of the fitted samples
    jacobian: Array  # shape (samples, p), scaled as its problem has it
    scales: Array  # shape (p,), the unit of each column

    @cached_property
    def basis(self) -> Array:
        """Orthonormal, shape (samples, <= p): what the base parameters can do to the residual."""
        seen = np.linalg.norm(self.jacobian, axis=0) > 0.0
        basis: Array = np.linalg.qr(self.jacobian[:, seen])[0]
        return basis

    @cached_property
    def rest(self) -> Array:
        """What is left of the residual, m, whatever the base parameters do, shape (samples,)."""
        return Projection(self.basis)(self.residual)


def base_of(evidence: Evidence, trial: Trial) -> Base:
    """The derivatives at a trial."""
    problem = problem_of(evidence, trial.model, trial.free)
    z = problem.point(trial.model, trial.initial_hysteresis)
    scales = np.append(problem.scales, problem.hysteresis_scales)
    return Base(trial, problem.residuals(z), problem.jacobian(z), scales)


def refine(
    evidence: Evidence,
    trial: Trial,
    tolerance: float = FINE,
    evaluations: int = 40,
) -> Trial:
    """`fit_on` from a trial, and judge what comes out."""
    return judged_once(evidence, fit_on(evidence, trial, tolerance, evaluations))


@np.errstate(all="ignore")  # a step too far may overflow: it is then not taken
def fit_on(
    evidence: Evidence,
    trial: Trial,
    tolerance: float,
    evaluations: int,
    fresh: Collection[str] | None = None,
    trust: float = 1.0,
) -> Trial:
    """Fit on from a trial; not judged yet.

    All derivatives are taken anew at each step, or only those by the parameters of the links
    `fresh`. The nominal model counts `trust` times as a `Prior` has it. Where the model diverges
    beside a point a fit cannot go on: the trial stays as it is.
    """
    problem = problem_of(evidence, trial.model, trial.free)
    z = problem.point(trial.model, trial.initial_hysteresis)
    if len(z) == 0:
        return trial
    jacobian: Callable[[Array], Array] = problem.jacobian
    try:
        if fresh is not None:
            anew = [index for index, (link, _) in enumerate(problem.free) if link in fresh]
            kept = [index for index in range(len(z)) if index not in anew]
            columns = np.zeros((len(problem.residuals(z)), len(z)), order="F")
            columns[:, kept] = problem.columns(z, kept)
            jacobian = _chord(problem, columns, anew)
        squares, z = _descend(evidence, problem, z, jacobian, tolerance, evaluations, trust)
    except (ValueError, FloatingPointError, np.linalg.LinAlgError):
        return trial
    return trial_at(problem, z, squares)


def begun(base: Base, model: Model, added: Sequence[str]) -> Trial:
    """Where a fit of `model`, the base's with the links `added`, begins; not fitted, nor judged."""
    kept = base.trial.free
    new = tuple(key for key in fitted_keys(model, added) if key not in kept)
    return Trial(model, (*kept, *new), base.trial.initial_hysteresis, math.inf)


def extend(evidence: Evidence, base: Base, model: Model, added: Sequence[str]) -> Trial | None:
    """Fit `model` by the chord method: the base's derivatives stay, those of `added` are fresh.

    Not judged yet; None if that fails.
    """
    problem, z = _opened(evidence, base, model, added)
    count, size = len(base.trial.free), len(problem.free)
    if len(z) != base.jacobian.shape[1] + size - count:
        return None
    scales = np.append(problem.scales, problem.hysteresis_scales)
    columns = np.zeros((base.jacobian.shape[0], len(z)), order="F")
    columns[:, :count] = base.jacobian[:, :count] * (scales[:count] / base.scales[:count])
    columns[:, size:] = base.jacobian[:, count:] * (scales[size:] / base.scales[count:])
    jacobian = _chord(problem, columns, range(count, size))
    try:
        own = problem.projected(z, columns)
        z = _met_half_way(problem, z, own, np.r_[:count, size : len(z)])
        squares, z = _descend(evidence, problem, z, jacobian, ROUGH, EVALUATIONS)
    except (ValueError, FloatingPointError, np.linalg.LinAlgError):
        return None
    return trial_at(problem, z, squares)


def half_way(evidence: Evidence, base: Base, model: Model, added: Sequence[str]) -> Trial | None:
    """Where a fit of `model` begins once the base's parameters have gone to meet the guess.

    Neither fitted nor judged; None where the model diverges beside the guess.
    """
    problem, z = _opened(evidence, base, model, added)
    own = np.r_[: len(base.trial.free), len(problem.free) : len(z)]
    try:
        z = _met_half_way(problem, z, problem.jacobian(z), own)
    except (ValueError, FloatingPointError, np.linalg.LinAlgError):
        return None
    return trial_at(problem, z, math.inf)


def _opened(
    evidence: Evidence, base: Base, model: Model, added: Sequence[str]
) -> tuple[Problem, Array]:
    """The problem of `model`, the base's with the links `added`, and where a fit of it begins."""
    start = begun(base, model, added)
    problem = problem_of(evidence, model, start.free)
    return problem, problem.point(model, start.initial_hysteresis)


def _chord(problem: Problem, columns: Array, anew: Sequence[int]) -> Callable[[Array], Array]:
    """The Jacobian with some columns taken anew at each point and the others kept."""

    def jacobian(z: Array) -> Array:
        found = problem.projected(z, columns)
        found[:, anew] = problem.columns(z, anew)
        return found

    return jacobian


def _met_half_way(problem: Problem, z: Array, jacobian: Array, base: Indices) -> Array:
    """A better start: the base parameters go part of the way to where the guess wants them.

    Raises FloatingPointError where the model diverges, which LAPACK would print a line about.
    """
    low, high = problem.bounds
    residuals = problem.residuals(z)
    columns = jacobian[:, base]
    if not (np.all(np.isfinite(columns)) and np.all(np.isfinite(residuals))):
        raise FloatingPointError("the model diverges beside a guess")
    sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    wanted = np.linalg.lstsq(columns / sizes, residuals, rcond=SEEN)[0] / sizes
    best, least = z, float(residuals @ residuals)
    for share in WAYS:
        other = z.copy()
        other[base] -= share * wanted
        other = np.clip(other, low, high)
        left = problem.residuals(other)
        squares = float(left @ left)
        if squares < least:
            best, least = other, squares
    return best


def _descend(
    evidence: Evidence,
    problem: Problem,
    z: Array,
    jacobian: Callable[[Array], Array],
    tolerance: float,
    evaluations: int,
    trust: float = 1.0,
) -> tuple[float, Array]:
    """Least squares from a point: the sum of squares, m^2, and where.

    The prior is weighed by what is left; where that falls by much, it is weighed again.
    """
    z = np.clip(z, *problem.bounds)
    left = problem.residuals(z)
    while True:
        before, prior = float(left @ left), Prior(evidence.nominal, problem, trust * left)
        z, left, used = _solve(problem, prior, z, jacobian, tolerance, evaluations)
        evaluations -= used
        squares = float(left @ left)
        if squares > MUCH * before or evaluations < 2:
            return squares, z


def _solve(
    problem: Problem,
    prior: Prior,
    z: Array,
    jacobian: Callable[[Array], Array],
    tolerance: float,
    evaluations: int,
) -> tuple[Array, Array, int]:
    """Where least squares with a prior end, the residual there, m, and the evaluations it took."""
    found, left, used = descend(
        lambda z: np.append(problem.residuals(z), prior.rows(z)),
        lambda z: np.vstack([jacobian(z), prior.jacobian(z)]),
        z,
        problem.bounds,
        tolerance,
        evaluations,
    )
    return found, left[: problem.samples], used
