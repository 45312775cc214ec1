"""One round of an exploration: each of some effects is added to an explanation.

All are screened, the promising are fitted, the best of them to the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence

import numpy as np

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import Base
from microgripper_control.diagnosis.fits.trial import Trial, added
from microgripper_control.diagnosis.search.attempt import attempt, promise
from microgripper_control.diagnosis.search.finishing import polish
from microgripper_control.diagnosis.search.labour import is_costly, is_long, is_long_with
from microgripper_control.diagnosis.search.pool import Pool, strongest
from microgripper_control.diagnosis.search.schedule import side_by_side
from microgripper_control.diagnosis.search.scrutiny import MOST_STARTS, STARTS, Scrutiny
from microgripper_control.diagnosis.search.stretches import GLANCE, PART
from microgripper_control.effects.base import Scales, Values, never_behind, no_courses
from microgripper_control.effects.registry import registry

RUNNERS_UP = 2  # of the promising: those that explain most by themselves,
SHOWN = 2  # and those of which what is left shows a sign
HARDLY = 0.95  # of the power: of the others what would leave more is not fitted
NEAR = 3.0  # times what the best leaves: what leaves less is fitted on, all derivatives fresh,
NEARER = 2.0  # but not so far off if nothing is wanting,
NEAR_IF_COSTLY = 1.5  # or if each sample is costly,
HELPED = 0.2  # of the power that the best takes away: such a one must take more by then,
FEW = 2  # and there are no more than so many of these


Progress = Callable[[str, int, int], None]  # what is being tried, how many are done, of how many


def silent(what: str, done: int, total: int) -> None:
    """No progress shown."""


def play(
    evidence: Evidence,
    bases: Sequence[Base],
    names: Sequence[str],
    most: int,
    pool: Pool,
    progress: Progress = silent,
    jobs: int = -1,
    shown: Collection[str] = (),
) -> None:
    """Add each of some effects to the bases: all are screened, up to `most` promising are fitted.

    `shown` are those of which the bases' residuals show a sign.
    """
    if most < len(names):
        names = _promising(evidence, bases, names, shown, pool, jobs)
        names = few_long(evidence, bases[0].trial, names)[:most]
    before = bases[0].trial
    alone = before is pool.refit
    pool.joined |= {(added(evidence, before), name) for name in names}
    tasks = [
        (evidence, bases, name, _scrutiny(name, alone, pool))
        for name in _long_first(names, evidence.scales)
    ]
    found = []
    progress("", 0, len(tasks))
    for done, (name, trial, why) in enumerate(side_by_side(attempt, tasks, jobs), start=1):
        progress(name, done, len(tasks))
        if trial is not None:
            found.append(trial)
        elif alone:
            pool.failures[name] = why
    for trial in found:
        pool.add(trial)
    # Far from the base its derivatives mislead: the best go on with fresh ones.
    if pool.leaves_more(before) and (best := _going_on(evidence, before, found, alone, pool)):
        progress("the best of them", 0, 1)
        for trial in side_by_side(polish, [(evidence, trial) for trial in best], jobs):
            pool.add(trial)


def _scrutiny(name: str, alone: bool, pool: Pool) -> Scrutiny:
    """How far an effect is worth being fitted, by what the best of the others leaves.

    What leaves nothing to explain cannot lose to another effect: a look is enough. Only a lag can
    lose to another lag: one of high order begins far off, and ends as near.
    """
    known = min((trial.fitted_rmse for trial in pool.tried.values()), default=np.inf)
    if alone and pool.unexplained:
        return Scrutiny(PART, known=known)
    if not alone:
        found = _by_itself(name, pool)
        return Scrutiny(GLANCE, MOST_STARTS, NEAR_IF_COSTLY * known, known, found)
    lags = all(map(is_lag, (name, *added(pool.evidence, pool.leader))))
    return Scrutiny(GLANCE, STARTS, math.inf if lags else NEAR_IF_COSTLY * known, known)


def is_lag(name: str) -> bool:
    """Whether an effect lets the reading be behind the command."""
    return registry()[name].behind is not never_behind


def _long_first(names: Sequence[str], scales: Scales) -> list[str]:
    """The effects in about the order of how long they take, so that no core is left waiting.

    Those with courses are projected off them anew at each step, others have many first guesses.
    """
    links = [registry()[name] for name in names]
    links.sort(key=lambda link: (link.courses is no_courses, -len(link.starts(scales))))
    return [link.name for link in links]


def _promising(
    evidence: Evidence,
    bases: Sequence[Base],
    names: Sequence[str],
    shown: Collection[str],
    pool: Pool,
    jobs: int,
) -> list[str]:
    """The effects that are worth a fit, in the order in which they are.

    First what promises most, then those that are strong alone, and those that show: a glance may
    miss a narrow resonance.
    """
    looks = [(evidence, bases, name, _by_itself(name, pool)) for name in names]
    found = dict(side_by_side(promise, looks, jobs))
    left = {name: found[name] for name in names}  # as they come they are in no order
    strong = strongest(left, pool)[:RUNNERS_UP]
    seen = sorted((name for name in left if name in shown), key=lambda name: left[name])
    first = {*strong, *seen[:SHOWN]}
    worth = [name for name in left if name in first or left[name] < HARDLY]
    best = min(worth, key=lambda name: left[name], default=None)
    return sorted(worth, key=lambda name: (name != best, name not in first, left[name]))


def few_long(evidence: Evidence, trial: Trial, names: Sequence[str]) -> list[str]:
    """Of those effects that take long beside a trial's only the first few, and all others."""
    others = [name for name in names if is_long_with(evidence, trial, name)][FEW:]
    return [name for name in names if name not in others]


def _by_itself(name: str, pool: Pool) -> list[Values]:
    """The values that an effect had when it was tried alone."""
    trial = pool.tried.get(frozenset([name]))
    return [trial.model.values(name)] if trial is not None else []


def _going_on(
    evidence: Evidence, before: Trial, found: Sequence[Trial], alone: bool, pool: Pool
) -> list[Trial]:
    """Those found that leave no more than so many times the least; of lags each, if one leads.

    A lag of high order begins far off, the more so from base parameters that had made up for it,
    and ends as near as another that is ahead.
    """
    near = NEARER if alone and not pool.unexplained else NEAR
    fits = [t for t in found if t.free != before.free and np.isfinite(t.fitted_rmse)]
    others = [trial for trial in pool.tried.values() if len(trial.free) > len(before.free)]
    least = min((trial.fitted_rmse for trial in (*fits, *others)), default=np.inf)
    cheap: list[Trial] = []
    costly: list[Trial] = []
    for trial in sorted(fits, key=lambda trial: trial.fitted_rmse):
        (costly if is_costly(evidence, trial.model) else cheap).append(trial)
    gained = max(0.0, before.fitted_rmse**2 - least**2)
    limit = min(NEAR_IF_COSTLY * least, math.sqrt(before.fitted_rmse**2 - HELPED * gained))
    few = 1 if costly and not alone and is_long(evidence, costly[0].model) else FEW
    leading = added(evidence, pool.leader)
    lags_race = alone and bool(leading) and all(map(is_lag, leading))

    def is_near(trial: Trial) -> bool:
        races = lags_race and all(map(is_lag, added(evidence, trial)))
        return races or trial.fitted_rmse < near * least

    return [
        *filter(is_near, cheap),
        *[trial for trial in costly if trial.fitted_rmse < limit][:few],
    ]
