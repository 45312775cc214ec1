"""The two searches of the paper's section 5: simplex, then trust-region least squares."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.optimize import least_squares, minimize

from microgripper_control.core.signals import Array
from microgripper_control.identification.elimination import turned_jacobian, turned_residuals
from microgripper_control.identification.nuisance import fit_nuisance
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.start import GRID_KEYS, better_start

SIMPLEX_EVALUATIONS = 200
NEAR = 1e-2  # of the start's values: from there the trust region's few steps are the shorter way


def simplex(problem: Problem) -> Array:
    """Nelder-Mead on the parameters alone, each recording's initial h as the start has it."""
    model = problem.model
    initial = [
        fit_nuisance(model, recording, problem.conditions).initial_hysteresis
        for recording in problem.recordings
    ]
    if set(GRID_KEYS) <= set(problem.free) and model.value("bouc_wen", "n") == 1.0:
        model, initial = better_start(problem, initial)
    start = problem.point(model, initial)
    count = len(problem.free)
    if not count:
        return start
    low, high = problem.bounds

    def squares(part: Array) -> float:
        residuals = problem.residuals(np.append(part, start[count:]))
        return float(residuals @ residuals) if np.all(np.isfinite(residuals)) else np.inf

    best = minimize(
        squares,
        start[:count],
        method="Nelder-Mead",
        bounds=list(zip(low[:count], high[:count], strict=True)),
        options={"maxfev": SIMPLEX_EVALUATIONS, "xatol": NEAR, "fatol": np.inf},
    )
    return np.append(best.x, start[count:])


@np.errstate(all="ignore")  # a step too far may overflow: it is then not taken
def descend(problem: Problem, z: Array) -> Array:
    """Trust-region reflective least squares from a point, parameters and initial h together."""
    low, high = problem.bounds
    inside = np.clip(z, low, high)
    if not len(inside):
        return inside
    best = least_squares(
        partial(turned_residuals, problem),
        inside,
        jac=partial(turned_jacobian, problem),
        bounds=(low, high),
        method="trf",
        x_scale="jac",
        xtol=1e-10,
        ftol=1e-12,
        gtol=1e-15,
    )
    return np.asarray(best.x)
