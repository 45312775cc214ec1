"""A fit that goes on to the end, as far as its cost allows."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import ROUGH, fit_on, refine
from microgripper_control.diagnosis.fits.trial import Trial, added, judged_once
from microgripper_control.diagnosis.search.labour import is_costly
from microgripper_control.diagnosis.search.stretches import MANY


class Effort(NamedTuple):
    """How far a round of a fit goes, and of what was left before it it must leave less to go on."""

    tolerance: float
    evaluations: int
    worth_another: float


POLISHED = 1e-5  # tolerance
TO_THE_END, BRIEFLY = Effort(POLISHED, 15, 0.99), Effort(1e-3, 6, 0.9)
MOST_ROUNDS = 3
STEPS = 9  # of a fit from a first guess, at most
ROUND_STEPS = 6  # of a round of a longer fit, all derivatives fresh
ROUNDS, FALLING = 5, 0.8  # of a long fit, as long as each leaves less than so much of the last


def refined(evidence: Evidence, trial: Trial, tolerance: float, evaluations: int) -> Trial:
    """Fit on and judge what comes out; with a costly force in rounds, with fewer derivatives.

    Those by the base parameters are taken once, or once a round, which has an `Effort` of its own.
    A costly force by itself, and few samples, are fitted to the end: it bends while it is fitted,
    and gets there late.
    """
    if not is_costly(evidence, trial.model):
        return refine(evidence, trial, tolerance, evaluations)
    few = sum(len(recording) for recording in evidence.fitted) <= MANY
    effort = TO_THE_END if few and len(added(evidence, trial)) == 1 else BRIEFLY
    for _ in range(MOST_ROUNDS):
        before = trial.fitted_rmse
        trial = fit_on(evidence, trial, effort.tolerance, effort.evaluations, fresh=trial.effects)
        if trial.fitted_rmse > effort.worth_another * before:
            break
    return judged_once(evidence, trial)


def polish(evidence: Evidence, trial: Trial) -> Trial:
    """Fit on with fresh derivatives and judge, in rounds as long as each leaves clearly less."""
    return _in_rounds(
        lambda one: refined(evidence, one, ROUGH, STEPS), trial, left=trial.fitted_rmse
    )


def while_it_falls(evidence: Evidence, trial: Trial, steps: int) -> Trial:
    """Fit on in rounds of some steps, as long as each leaves clearly less than the one before."""
    return _in_rounds(lambda one: fit_on(evidence, one, ROUGH, steps), trial, left=math.inf)


def _in_rounds(go_on: Callable[[Trial], Trial], trial: Trial, left: float) -> Trial:
    """Go on with a trial; `left`, m, is what the round before is said to have left."""
    for _ in range(ROUNDS):
        trial = go_on(trial)
        if not trial.fitted_rmse < FALLING * left:
            break
        left = trial.fitted_rmse
    return trial
