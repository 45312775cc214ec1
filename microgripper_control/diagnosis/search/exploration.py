"""Which explanations are tried: each effect alone, then the best with a second and a third.

Forward selection on the fitted samples with a backward check; every explanation that was tried is
kept, and how probable each is follows from all of them together (see `weighing`).
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.data.residuals import fitted_residuals
from microgripper_control.diagnosis.fits.fitting import base_of
from microgripper_control.diagnosis.fits.trial import Trial, added, unfitted, without
from microgripper_control.diagnosis.search.attempt import behind
from microgripper_control.diagnosis.search.clocked_lags import on_the_sensors_clock
from microgripper_control.diagnosis.search.finishing import POLISHED, refined
from microgripper_control.diagnosis.search.further_part import add_further_parts
from microgripper_control.diagnosis.search.labour import (
    is_costly,
    is_costly_with,
    is_force,
    is_light_with,
    is_long,
    may_join,
)
from microgripper_control.diagnosis.search.likening import add_likened
from microgripper_control.diagnosis.search.pool import Pool, is_read_off, strongest
from microgripper_control.diagnosis.search.resettling import afresh, again_if_settled
from microgripper_control.diagnosis.search.rounds import Progress, is_lag, play, silent
from microgripper_control.diagnosis.search.schedule import side_by_side
from microgripper_control.diagnosis.search.superposition import add_superposed, alike
from microgripper_control.diagnosis.signs.signatures import signatures
from microgripper_control.effects.registry import registry

MOST_EFFECTS = 3
BEAM = 2  # explanations that a further effect is added to
SECONDS, SECONDS_IF_COSTLY = 7, 3  # second effects that are fitted, the most promising,
THIRDS = 3  # and third ones
UNCLOSED_IF_COSTLY = 0.25  # of the gap: a costly force that leaves less leads no other effect,
UNCLOSED_IF_LONG = 0.4  # and one with long simulations that leaves less only
SECONDS_IF_LONG = 2  # others, the strongest by themselves: a round takes ten minutes
FAIR_PART = 0.2  # of the gap; two independent effects of one size close 0.3 of it each
FOLLOWED = 0.9  # of what the refit leaves: a course that leaves more follows nothing much
MUCH_LESS = 0.7  # of what the best with an effect less leaves: a pair worth taking apart as well
EXCHANGED = 2  # effects that may be meant in the place of another, at most
RIVAL = 0.7  # of what the best closes: what the second must close to be a leader as well,
RIVAL_IF_COSTLY = 0.9  # and what it must with a costly force,
RIVAL_IF_SHOWN = 0.5  # or if what the refit leaves shows a sign of it


def alone(
    evidence: Evidence,
    nominal: Trial,
    refits: Sequence[Trial],
    candidates: Sequence[str],
    progress: Progress = silent,
    jobs: int = -1,
) -> Pool:
    """Try the candidates one at a time.

    They are added to the refits, of which the first is the best, and to the nominal model.
    """
    refit, *others = refits
    pool = Pool(evidence, nominal, refit)
    names = [name for name in candidates if name not in pool.own]
    far = replace(nominal, free=refit.free)  # from where it is, but no parameter stays there
    bases = [base_of(evidence, trial) for trial in (refit, *others, far)]
    # From cheap to costly: a look is enough at what costs more and has nothing left to explain.
    first = [name for name in names if _is_first(name, evidence, refit)]
    rest = [name for name in names if name not in first]
    costly = [name for name in rest if is_costly_with(evidence, refit, name)]
    # A refit that makes up for a lag goes far astray: all lags begin from the nominal model, too.
    lags = [name for name in rest if is_lag(name) and name not in costly]
    cheap = [name for name in rest if name not in {*lags, *costly}]
    play(evidence, bases, first, len(first), pool, progress, jobs)
    pool = on_the_sensors_clock(pool, jobs)
    evidence = pool.evidence
    for some in (lags, cheap, costly):
        near = bases if pool.unexplained or some is lags else bases[:-1]
        play(evidence, near, some, len(some), pool, progress, jobs)
    pool = again_if_settled(pool, jobs)
    add_further_parts(pool, jobs)
    add_likened(pool, names, jobs)
    return pool


def together(
    pool: Pool, candidates: Sequence[str], progress: Progress = silent, jobs: int = -1
) -> Pool:
    """Try the candidates with each other, as far as there is anything left to explain."""
    names = [name for name in candidates if name not in pool.own]
    fitted = [name for name in names if not is_read_off(name)]
    if _worth_joining(pool, 1):
        _add_further(fitted, pool, progress, jobs)
    _exchange(fitted, pool, progress, jobs)
    if (size := len(added(pool.evidence, pool.closest))) > 1:
        pool = on_the_sensors_clock(pool, jobs, size)
    _begin_anew(pool, progress, jobs)
    add_further_parts(pool, jobs)
    if len(added(pool.evidence, pool.leader)) > 1:
        add_likened(pool, fitted, jobs)
    _check_backwards(pool)
    _add_chosen(pool, names)
    return pool


def _is_first(name: str, evidence: Evidence, refit: Trial) -> bool:
    """Whether an effect is tried before others: it is cheap, or may show the sensor's clock."""
    if registry()[name].clocked:
        return True
    return not is_force(name) and is_light_with(evidence, refit, name)


def _add_further(names: Sequence[str], pool: Pool, progress: Progress, jobs: int) -> None:
    """Add a second effect to the best explanations, and a third while that is worth it."""
    shown = set(_shown_by(pool.refit, pool))
    for size in range(1, MOST_EFFECTS):
        led: set[str] = set()
        for leader in pool.best(size, BEAM):
            if _may_lead(leader, pool, size, shown):
                led |= added(pool.evidence, leader)
                _join(leader, names, pool, progress, jobs)
        if size == 1:  # neither of two effects need be among the best alone
            add_superposed(names, pool, progress, jobs)
            _join_courses(names, led, pool, progress, jobs)
        if not _worth_joining(pool, size + 1):
            return


def _join_courses(
    names: Sequence[str], led: Set[str], pool: Pool, progress: Progress, jobs: int
) -> None:
    """Try others beside a drift or a hum, as long as more than a right law would leave is left.

    By itself a course follows part of what another effect does, and does harm where it is judged:
    what the two would leave is not told by either. Not beside those that have `led` already.
    """
    for name in (n for n in names if n not in led):
        course = pool.tried.get(frozenset([name]))
        if course is None or not registry()[name].random or not pool.leaves_more(pool.leader):
            continue
        if course.fitted_rmse < FOLLOWED * pool.refit.fitted_rmse:
            _join(course, names, pool, progress, jobs)


def _worth_joining(pool: Pool, size: int) -> bool:
    """Whether anything is to be gained by one effect more than `size`.

    The last one that was added must have closed a fair part of the gap.
    """
    if not (best := pool.best(size, 1)) or not pool.leaves_more(best[0]):
        return False
    if size == 1:
        return pool.closed(best[0]) > FAIR_PART
    if is_costly(pool.evidence, best[0].model):
        return False  # a third effect beside such a force would take minutes
    return _adds_much(best[0], pool)


def _adds_much(trial: Trial, pool: Pool) -> bool:
    """Whether an explanation closes a fair part of the gap more than any with an effect less."""
    return pool.closed(trial) - pool.closed(_with_one_less(trial, pool)) > FAIR_PART


def _leaves_much_less(trial: Trial, pool: Pool) -> bool:
    """Whether an explanation leaves much less than those with an effect less."""
    fewer = _with_one_less(trial, pool)
    return 1.0 - pool.closed(trial) < MUCH_LESS * (1.0 - pool.closed(fewer))


def _with_one_less(trial: Trial, pool: Pool) -> Trial:
    """The best explanation with an effect less than another."""
    return pool.best(len(added(pool.evidence, trial)) - 1, 1)[0]


def _may_lead(leader: Trial, pool: Pool, size: int, shown: Set[str]) -> bool:
    """Whether one of the best explanations with `size` effects is worth a further one."""
    costly = is_costly(pool.evidence, leader.model)
    if costly and 1.0 - pool.closed(leader) < UNCLOSED_IF_COSTLY:
        return False
    best = pool.best(size, 1)
    near = RIVAL_IF_COSTLY if costly else RIVAL
    if not costly and not shown.isdisjoint(added(pool.evidence, leader)):
        near = RIVAL_IF_SHOWN
    if pool.closed(leader) < near * pool.closed(best[0]):
        return False
    return pool.leaves_more((pool.best(size + 1, 1) or best)[0])


def _join(leader: Trial, names: Sequence[str], pool: Pool, progress: Progress, jobs: int) -> None:
    """Add each of some effects to a leader once it has been fitted to the end."""
    evidence = pool.evidence
    third = len(added(evidence, leader)) > 1
    most = SECONDS_IF_COSTLY if is_costly(evidence, leader.model) else THIRDS if third else SECONDS
    leader = refined(evidence, leader, POLISHED, 60)
    pool.add(leader)
    if is_long(evidence, leader.model) and 1.0 - pool.closed(leader) < UNCLOSED_IF_LONG:
        rest = _untried_beside(leader, names, pool)[:SECONDS_IF_LONG]
    else:
        rest = [n for n in names if n not in leader.effects and may_join(evidence, leader, n)]
    if not rest:
        return
    shown = _shown_by(leader, pool)
    play(evidence, [base_of(evidence, leader)], rest, most, pool, progress, jobs, shown)


def _exchange(names: Sequence[str], pool: Pool, progress: Progress, jobs: int) -> None:
    """Try in the place of each of the best two effects what explained about the same alone.

    Which of them led was chosen without the other, whose part of the gap misled both. Where the two
    leave more than noise, what promises most beside either is tried, alike or not, unless the one
    that stays is costly. What is costly only takes a costly one's place, or a play's, which is as
    much of the way as friction.
    """
    best = pool.best(2, 1)
    if not best:
        return
    pair, wanting = added(pool.evidence, best[0]), pool.leaves_a_rest(best[0])
    if not (_adds_much(best[0], pool) or (wanting and _leaves_much_less(best[0], pool))):
        return
    for name in sorted(pair):
        replaced, kept = pool.tried.get(frozenset([name])), pool.tried.get(pair - {name})
        if not (replaced and kept):
            continue
        others = _untried_beside(kept, names, pool)
        if not (registry()[name].of_the_way or is_costly(pool.evidence, replaced.model)):
            others = _without_costly(others, pool)
        if not wanting or is_costly(pool.evidence, kept.model):
            others = alike(name, others, pool)[:EXCHANGED]
        if others:
            base = base_of(pool.evidence, kept)
            play(pool.evidence, [base], others, EXCHANGED, pool, progress, jobs)


def _begin_anew(pool: Pool, progress: Progress, jobs: int) -> None:
    """Fit each effect of the best explanation by several from first guesses, if it leaves a rest.

    What joined first was chosen on a part of the samples, beside others that were still fitted to
    its share of the gap. What is costly to simulate is not worth the time.
    """
    evidence, best = pool.evidence, pool.closest
    effects = added(evidence, best)
    if len(effects) < 2 or not pool.leaves_a_rest(best) or is_costly(evidence, best.model):
        return
    progress("the best of them anew", 0, 1)
    tasks = [
        (
            evidence,
            base_of(evidence, unfitted(evidence, without(best, name))),
            name,
            best.fitted_rmse,
        )
        for name in sorted(effects)
        if not is_read_off(name)
    ]
    for trials in side_by_side(afresh, tasks, jobs):
        for trial in trials:
            pool.add(trial)


def _untried_beside(kept: Trial, names: Sequence[str], pool: Pool) -> list[str]:
    """The effects of `names` that may join `kept` and gain by it; what closes most first."""
    return [
        name
        for name in strongest(names, pool)
        if pool.may_gain(kept, name) and may_join(pool.evidence, kept, name)
    ]


def _without_costly(names: Sequence[str], pool: Pool) -> list[str]:
    """Those effects of `names` that are not costly by themselves."""
    alone = [(name, pool.tried[frozenset([name])]) for name in names]
    return [name for name, trial in alone if not is_costly(pool.evidence, trial.model)]


def _shown_by(leader: Trial, pool: Pool) -> list[str]:
    """The effects of which what an explanation leaves where it was fitted shows a sign."""
    left = fitted_residuals(pool.evidence, leader.model)
    return [sign.effect for sign in signatures(left, pool.noise_floor) if sign.agrees]


def _check_backwards(pool: Pool) -> None:
    """Try the best explanation without each of its effects, briefly what was tried before."""
    best = pool.leader
    effects = added(pool.evidence, best)
    if len(effects) < 2:
        return
    for name in sorted(effects):
        known = effects - {name} in pool.tried
        pool.add(refined(pool.evidence, without(best, name), POLISHED, 4 if known else 15))


def _add_chosen(pool: Pool, names: Sequence[str]) -> None:
    """Put effects that are read off, not fitted (a sensor's grid), behind the best explanations."""
    pool.drop_idle_grid()
    leaders = [trial for size in range(1, MOST_EFFECTS) for trial in pool.best(size, BEAM)]
    for name in (n for n in names if is_read_off(n) and frozenset([n]) in pool.tried):
        for leader in leaders:
            if name not in leader.effects:
                pool.add(behind(pool.evidence, leader, name))
