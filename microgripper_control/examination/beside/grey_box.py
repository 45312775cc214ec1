"""Textbook selection among grey-box models: refit each candidate, take the smallest BIC.

BIC = n ln(SSE / n) + k ln n with n the number of fitted samples and k that of fitted values
(Schwarz 1978), as if all samples were independent. It always names something.

The candidates are the library's, and so are their first guess, the ranges that are plausible on the
rig at hand, and the prior that keeps base parameters near the nominal ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from microgripper_control.diagnosis.diagnose import candidate_names
from microgripper_control.diagnosis.findings import NONE, PARAMETERS
from microgripper_control.diagnosis.fits.fitting import refine
from microgripper_control.diagnosis.fits.trial import Trial, fitted_keys, problem_of
from microgripper_control.effects.registry import registry
from microgripper_control.examination.beside.evidence import Begun

EVALUATIONS = 40  # of one fit at most; with ten a play and a lag stop half way
TOLERANCE = 1e-5


def select(begun: Begun, withheld: Sequence[str] = ()) -> tuple[str, str | None, float]:
    """The answer with the smallest BIC, its stage, and its error on the held-out samples, m."""
    best = min(_tried(begun, withheld), key=lambda tried: tried[0])
    _, answer, rmse = best
    return answer, registry()[answer].stage.value if answer in registry() else None, rmse


def _tried(begun: Begun, withheld: Sequence[str]) -> Iterator[tuple[float, str, float]]:
    """BIC, answer and held-out error of each."""
    nuisances = len(begun.nominal.initial_hysteresis)
    refit = begun.refit
    yield _bic(begun, begun.nominal, nuisances), NONE, begun.nominal.rmse
    yield _bic(begun, refit, nuisances + len(refit.free)), PARAMETERS, refit.rmse
    for name in candidate_names():
        if name in withheld:
            continue
        trial = _fitted(begun, name)
        if trial is not None and math.isfinite(trial.rmse):
            yield _bic(begun, trial, nuisances + len(trial.free)), name, trial.rmse


def _bic(begun: Begun, trial: Trial, values: int) -> float:
    count = sum(int(np.count_nonzero(used)) for used in begun.evidence.used)
    problem = problem_of(begun.evidence, trial.model, ())
    values += sum(problem.eliminated)
    return 2.0 * count * math.log(trial.fitted_rmse) + values * math.log(count)


def _fitted(begun: Begun, name: str) -> Trial | None:
    """The refit with an effect at its first start, all of it fitted; None where that fails."""
    starts = registry()[name].starts(begun.evidence.scales)
    if not starts:
        return None
    model = begun.refit.model.with_link(name, **starts[0])
    free = (*begun.refit.free, *fitted_keys(model, [name]))
    start = replace(begun.refit, model=model, free=free)
    try:
        return refine(begun.evidence, start, TOLERANCE, EVALUATIONS)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return None
