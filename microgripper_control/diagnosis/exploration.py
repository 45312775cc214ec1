"""Which explanations are tried: each effect alone, then the best with a second and a third.

Forward selection on the fitted samples with a backward check; every explanation that was tried is
kept, and how probable each is follows from all of them together (see `weighing`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from microgripper_control.diagnosis.attempt import ROUGH, STEPS, attempt, behind, polish, promise
from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.fitting import Base, base_of, refine
from microgripper_control.diagnosis.noise import removable
from microgripper_control.diagnosis.part import (
    GLANCE,
    PART,
    is_dear,
    is_dear_with,
    is_force,
    may_join,
    refined,
)
from microgripper_control.diagnosis.pool import Pool
from microgripper_control.diagnosis.schedule import side_by_side
from microgripper_control.diagnosis.trial import Trial, judged, unfitted
from microgripper_control.effects.base import Scales, no_courses
from microgripper_control.effects.registry import registry

MOST_EFFECTS = 3
BEAM = 2  # explanations that a further effect is added to
SECONDS, SECONDS_IF_DEAR = 5, 3  # further effects that are fitted, the most promising,
RUNNERS_UP = 2  # among them those that explain most by themselves
UNEXPLAINED = 0.3  # of the noise floor: a structured rest above it asks for another effect,
UNCLOSED = 0.1  # if it is more of the gap than a law leaves that is right but not the rig's own,
UNCLOSED_IF_DEAR = 0.25  # and more than that beside a dear force, where it takes a minute
FAIR_PART = 0.2  # of the gap; two independent effects of one size close 0.3 of it each
RIVAL = 0.7  # of what the best closes: what the second must close to be a leader as well,
RIVAL_IF_DEAR = 0.9  # and what it must with a force that remembers the way
NEAR = 3.0  # times what the best leaves: what leaves less is fitted on, all derivatives fresh,
NEAR_IF_JOINED = 1.5  # but not so far off if it joins another and each sample is dear,
FEW = 2  # and no more than so many of these, if they have helped at all by then
LEADERS = 4  # explanations by one effect that are fitted again on settled evidence
POLISHED = 1e-5  # tolerance

Progress = Callable[[str, int, int], None]  # what is being tried, how many are done, of how many


def silent(what: str, done: int, total: int) -> None:
    """No progress shown."""


def explore(
    evidence: Evidence,
    nominal: Trial,
    refits: Sequence[Trial],
    candidates: Sequence[str],
    progress: Progress = silent,
    jobs: int = -1,
) -> Pool:
    """Try the candidates, alone and together, as far as there is anything to explain.

    They are added to the refits, of which the first is the best, and to the nominal model.
    """
    refit, *others = refits
    pool = Pool(evidence, nominal, refit)
    names = [name for name in candidates if name not in pool.own]
    fitted = [name for name in names if not _is_read_off(name)]
    far = replace(nominal, free=refit.free)  # from where it is, but no parameter stays there
    bases = [base_of(evidence, trial) for trial in (refit, *others, far)]
    # From cheap to dear: a look is enough at what costs more and has nothing left to explain.
    cheap = [name for name in names if not is_force(name)]
    dear = [name for name in names if is_dear_with(evidence, refit, name)]
    for some in (cheap, [name for name in names if name not in (*cheap, *dear)], dear):
        for trial in _round(evidence, bases, some, len(some), pool, progress, jobs):
            pool.add(trial)
    pool = _settled(pool, jobs)
    evidence = pool.evidence
    for size in range(1, MOST_EFFECTS):
        best = pool.best(size, 1)
        if not best or not _unexplained(best, pool) or not _worth_it(pool, size):
            break
        if size > 1 and is_dear(evidence, best[0].model):
            break  # a third effect beside such a force would take minutes
        for leader in pool.best(size, BEAM):
            costly = is_dear(evidence, leader.model)
            near = RIVAL_IF_DEAR if costly else RIVAL
            follower = _closed(leader, pool) < near * _closed(best[0], pool)
            if costly and 1.0 - _closed(leader, pool) < UNCLOSED_IF_DEAR:
                continue
            if follower or not _unexplained(pool.best(size + 1, 1) or best, pool):
                continue
            leader = refined(evidence, leader, POLISHED, 60)
            pool.add(leader)
            rest = [
                name
                for name in fitted
                if name not in leader.effects and may_join(evidence, leader, name)
            ]
            bases = [base_of(evidence, leader)]
            most = SECONDS_IF_DEAR if costly else SECONDS
            for trial in _round(evidence, bases, rest, most, pool, progress, jobs):
                pool.add(trial)
    _check_backwards(evidence, pool)
    _add_chosen(evidence, pool, names)
    return pool


def _settled(pool: Pool, jobs: int) -> Pool:
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
    leaders = {
        name: trial
        for trial in pool.best(1, LEADERS)
        for name in frozenset(trial.effects) - pool.own
        if not _is_read_off(name)
    }
    others = [trial for trial in pool.tried.values() if trial not in leaders.values()]
    for trial in side_by_side(_as_it_was, [(evidence, trial) for trial in others], jobs):
        settled.add(trial)
    for trial in side_by_side(polish, [(evidence, trial) for trial in leaders.values()], jobs):
        settled.add(trial)
    # What the first period has led astray begins afresh, unless nothing is left to explain.
    if _unexplained(settled.best(1, 1) or [settled.refit], settled):
        base = base_of(evidence, settled.refit)
        tasks = [
            (evidence, base, name)
            for name, trial in leaders.items()
            if not is_dear(evidence, trial.model)
        ]
        for trials in side_by_side(_afresh, tasks, jobs):
            for trial in trials:
                settled.add(trial)
    return min(pool, settled, key=lambda one: min(t.rmse for t in (one.refit, *one.tried.values())))


def _is_read_off(effect: str) -> bool:
    return registry()[effect].read_off


def _as_it_was(evidence: Evidence, trial: Trial) -> Trial:
    """A trial judged with the same values on other evidence."""
    return judged(evidence, unfitted(evidence, trial))


def _afresh(evidence: Evidence, base: Base, name: str) -> list[Trial]:
    """The best fit of an effect from first guesses, as it is and fitted on to the end."""
    found = attempt(evidence, [base], name, PART, np.inf)[1]
    return [] if found is None else [found, refined(evidence, found, POLISHED, 60)]


def _unexplained(best: Sequence[Trial], pool: Pool) -> bool:
    """Whether the best explanation leaves more than a right law would."""
    floor = pool.noise_floor
    rest = removable(best[0].both, floor)
    return rest > max(UNEXPLAINED * floor, UNCLOSED * removable(pool.refit.both, floor))


def _worth_it(pool: Pool, size: int) -> bool:
    """Whether the last effect that was added closed a fair part of the gap."""
    before = _closed(pool.best(size - 1, 1)[0], pool) if size > 1 else 0.0
    return _closed(pool.best(size, 1)[0], pool) - before > FAIR_PART


def _closed(trial: Trial, pool: Pool) -> float:
    """The share of the gap, as an error, that an explanation closes."""
    gap = removable(pool.refit.both, pool.noise_floor)
    return 1.0 - removable(trial.both, pool.noise_floor) / gap if gap > 0.0 else 0.0


def _check_backwards(evidence: Evidence, pool: Pool) -> None:
    """Try the best explanation without each of its effects, briefly what was tried before."""
    best = min([pool.refit, *pool.tried.values()], key=lambda trial: trial.both)
    added = [name for name in best.effects if name not in pool.own]
    if len(added) < 2:
        return
    for name in added:
        model = best.model.without([name])
        free = tuple(key for key in best.free if key[0] != name)
        start = Trial(model, free, best.initial_hysteresis, best.fitted_rmse)
        known = frozenset(best.effects) - pool.own - {name} in pool.tried
        pool.add(refined(evidence, start, POLISHED, 4 if known else 15))


def _add_chosen(evidence: Evidence, pool: Pool, names: Sequence[str]) -> None:
    """Put effects that are read off, not fitted (a sensor's grid), behind the best explanations."""
    pool.drop_refuted_grid()
    leaders = [trial for size in range(1, MOST_EFFECTS) for trial in pool.best(size, BEAM)]
    for name in (n for n in names if _is_read_off(n) and frozenset([n]) in pool.tried):
        for leader in leaders:
            if name not in leader.effects:
                pool.add(behind(evidence, leader, name))


def _round(
    evidence: Evidence,
    bases: Sequence[Base],
    names: Sequence[str],
    most: int,
    pool: Pool,
    progress: Progress,
    jobs: int,
) -> Iterator[Trial]:
    """Add each of some effects to the bases: all are screened, the `most` promising are fitted."""
    if most < len(names):
        names = _promising(evidence, bases, names, pool, jobs)[:most]
    found = []
    before = bases[0].trial
    first = before is pool.refit
    # What leaves nothing to explain cannot lose to another effect: a look at each is enough.
    wanting = first and _unexplained(pool.best(1, 1) or [before], pool)
    shown, near = (PART, NEAR) if wanting else (GLANCE, NEAR_IF_JOINED)
    known = [trial.fitted_rmse for trial in pool.tried.values()]
    hopeless = np.inf if wanting or not known else near * min(known)
    tasks = [
        (evidence, bases, name, shown, hopeless) for name in _long_first(names, evidence.scales)
    ]
    progress("", 0, len(tasks))
    for done, (name, trial, why) in enumerate(side_by_side(attempt, tasks, jobs), start=1):
        progress(name, done, len(tasks))
        if trial is not None:
            found.append(trial)
        else:
            pool.failures[name] = why
    yield from found
    # Far from the base its derivatives mislead: the best go on with fresh ones.
    fits = [t for t in found if t.free != before.free and np.isfinite(t.fitted_rmse)]
    best = sorted(fits, key=lambda trial: trial.fitted_rmse)
    if not best or not _unexplained([before], pool):
        return
    progress("the best of them", 0, 1)
    fits += [trial for trial in pool.tried.values() if len(trial.free) > len(before.free)]
    least = min(trial.fitted_rmse for trial in fits)
    near = min(near * least, before.fitted_rmse)
    yield from side_by_side(
        polish, [(evidence, t) for t in _going_on(evidence, best, least, near)], jobs
    )


def _long_first(names: Sequence[str], scales: Scales) -> list[str]:
    """The effects in about the order of how long they take, so that no core is left waiting.

    Those with courses are projected off them anew at each step, others have many first guesses.
    """
    links = [registry()[name] for name in names]
    links.sort(key=lambda link: (link.courses is no_courses, -len(link.starts(scales))))
    return [link.name for link in links]


def _promising(
    evidence: Evidence, bases: Sequence[Base], names: Sequence[str], pool: Pool, jobs: int
) -> list[str]:
    """The effects in the order in which they are worth a fit; first those that are strong alone."""
    looks = [(evidence, bases, name) for name in names]
    left: Mapping[str, float] = dict(side_by_side(promise, looks, jobs))
    alone = [name for trial in pool.best(1, len(pool.tried)) for name in trial.effects]
    strong = [name for name in alone if name in left][:RUNNERS_UP]
    return sorted(left, key=lambda name: (name not in strong, left[name]))


def _going_on(evidence: Evidence, best: Sequence[Trial], least: float, near: float) -> list[Trial]:
    """Those that leave no more than a few times the least, and dear ones that leave `near`, m."""
    costs = [is_dear(evidence, trial.model) for trial in best]
    cheap = [t for t, dear in zip(best, costs, strict=True) if not dear]
    dear = [t for t, dear in zip(best, costs, strict=True) if dear and t.fitted_rmse < near]
    return [*(t for t in cheap if t.fitted_rmse < NEAR * least), *dear[:FEW]]
