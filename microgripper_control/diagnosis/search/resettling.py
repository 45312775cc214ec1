"""What was explored, once more on settled evidence.

The first periods have chosen where the fits go on from.
"""

from __future__ import annotations

import math
from dataclasses import replace

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import ROUGH, Base, base_of, refine
from microgripper_control.diagnosis.fits.trial import Trial, added, unfitted
from microgripper_control.diagnosis.search.attempt import attempt
from microgripper_control.diagnosis.search.finishing import POLISHED, STEPS, polish, refined
from microgripper_control.diagnosis.search.labour import is_costly
from microgripper_control.diagnosis.search.pool import Pool, is_read_off
from microgripper_control.diagnosis.search.schedule import side_by_side
from microgripper_control.diagnosis.search.scrutiny import Scrutiny
from microgripper_control.diagnosis.search.stretches import PART

LEADERS = 4  # explanations by one effect that are fitted on,
BEGUN = 7  # and as many that begin afresh: what was led astray most may have come last


def again_if_settled(pool: Pool, jobs: int) -> Pool:
    """The same on settled evidence, where that foretells the judging samples better.

    The first periods have chosen where the fits go on from. They are kept if they are worth more
    than they spoil: the first rise may be the only one of its kind.
    """
    evidence = pool.evidence.settled()
    if evidence is pool.evidence:
        return pool
    settled = Pool(
        evidence,
        _as_it_was(evidence, pool.nominal),
        refine(evidence, pool.refit, ROUGH, STEPS),
        failures=pool.failures,
    )
    tried = [(evidence, trial) for trial in pool.tried.values()]
    for trial in side_by_side(_as_it_was, tried, jobs):
        settled.add(trial)
    leaders = [(evidence, trial) for trial in _of_one_effect(pool, LEADERS).values()]
    for trial in side_by_side(polish, leaders, jobs):
        settled.add(trial)
    # What the first period has led astray begins afresh, unless nothing is left to explain.
    if settled.unexplained:
        base = base_of(evidence, settled.refit)
        tasks = [
            (evidence, base, name)
            for name, trial in _of_one_effect(pool, BEGUN).items()
            if not is_costly(evidence, trial.model)
        ]
        for trials in side_by_side(afresh, tasks, jobs):
            for trial in trials:
                settled.add(trial)
    return min(pool, settled, key=lambda one: min(t.rmse for t in (one.refit, *one.tried.values())))


def _of_one_effect(pool: Pool, count: int) -> dict[str, Trial]:
    """The best explanations by one effect that is fitted, of all, by that effect."""
    return {
        name: trial
        for trial in pool.best(1, count)
        for name in added(pool.evidence, trial)
        if not is_read_off(name)
    }


def _as_it_was(settled: Evidence, trial: Trial) -> Trial:
    """A trial with the same values on settled evidence, which is judged by the same samples."""
    return replace(unfitted(settled, trial), errors=trial.errors)


def afresh(evidence: Evidence, base: Base, name: str, known: float = math.inf) -> list[Trial]:
    """The best fit of an effect from first guesses, as it is and fitted on to the end.

    `known` is what the best of the others leaves, m.
    """
    found = attempt(evidence, [base], name, Scrutiny(PART, known=known))[1]
    return [] if found is None else [found, refined(evidence, found, POLISHED, 60)]
