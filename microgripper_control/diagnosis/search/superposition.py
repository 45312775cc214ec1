"""Which two effects may explain together what neither does alone, told by what each takes away.

To first order two small effects add up. What each takes away by itself, as much of it as fits best
beside the other and beside the base parameters, tells what both would leave. That takes a linear
least-squares fit for a pair, so that all are asked: neither needs to be among the best alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, islice

import numpy as np
from scipy.optimize import nnls

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import Base, base_of
from microgripper_control.diagnosis.fits.trial import Trial, problem_of
from microgripper_control.diagnosis.search.labour import may_join
from microgripper_control.diagnosis.search.pool import Pool, strongest
from microgripper_control.diagnosis.search.rounds import Progress, play, silent
from microgripper_control.identification.nuisance import Projection

Pair = frozenset[str]

TINY = 1e-30  # m: what takes nothing away is like nothing
TRIED = 6  # pairs at most, the most promising,
AS_GOOD = 1.1  # times what the best of all would leave: those that would leave more are none
ALIKE = 0.8  # cosine of what two effects take away: one may be meant in the other's place


def add_superposed(
    names: Sequence[str], pool: Pool, progress: Progress = silent, jobs: int = -1
) -> None:
    """Try the most promising pairs that were not tried yet, as long as more than noise is left."""
    if not pool.leaves_a_rest(pool.leader):
        return
    left = superposed(names, pool)
    least = min(left.values(), default=math.inf)
    near = [pair for pair in left if left[pair] <= AS_GOOD * least]
    for leader, seconds in _by_leader(near, pool):
        base = base_of(pool.evidence, leader)
        play(pool.evidence, [base], seconds, len(seconds), pool, progress, jobs)
        if not pool.leaves_a_rest(pool.leader):
            return


def _by_leader(pairs: Sequence[Pair], pool: Pool) -> list[tuple[Trial, list[str]]]:
    """What is to lead the first of some pairs, and what is to join it, of all its pairs at once.

    What explains more of a pair alone leads it, unless it has done so in vain.
    """
    seconds: dict[str, list[str]] = {}
    for stronger, weaker in islice(_untried(pairs, pool), TRIED):
        seconds.setdefault(stronger, []).append(weaker)
    return [(pool.tried[Pair([first])], others) for first, others in seconds.items()]


def _untried(pairs: Sequence[Pair], pool: Pool) -> Iterator[tuple[str, str]]:
    """Leader and second of the pairs that may gain by being tried."""
    for first, second in (strongest(pair, pool) for pair in pairs):
        for leader, joins in ((first, second), (second, first)):
            alone = pool.tried[Pair([leader])]
            if pool.may_gain(alone, joins):
                yield leader, joins
                break


def superposed(names: Sequence[str], pool: Pool) -> dict[Pair, float]:
    """What two of some effects that were tried alone would leave of the fitted samples, m rms.

    Only of those that may be tried together, or were. What would leave the least comes first.
    """
    base = base_of(pool.evidence, pool.refit)
    taken = _all_taken(names, base, pool)
    pairs = map(Pair, combinations(taken, 2))
    left = {pair: _left(base, taken, sorted(pair)) for pair in pairs if _may_be_tried(pair, pool)}
    return dict(sorted(left.items(), key=lambda one: one[1]))


def _may_be_tried(pair: Pair, pool: Pool) -> bool:
    first, second = sorted(pair)
    return pair in pool.tried or may_join(pool.evidence, pool.tried[Pair([first])], second)


def alike(name: str, others: Sequence[str], pool: Pool) -> list[str]:
    """The effects that alone take away nearly the same as one does, what is most alike first."""
    taken = _all_taken([name, *others], base_of(pool.evidence, pool.refit), pool)
    ways = {effect: way / max(float(np.linalg.norm(way)), TINY) for effect, way in taken.items()}
    cosines = {other: float(ways[name] @ ways[other]) for other in others}
    return sorted((o for o in others if cosines[o] >= ALIKE), key=lambda other: -cosines[other])


def _all_taken(names: Sequence[str], base: Base, pool: Pool) -> dict[str, Array]:
    """What each effect that was tried alone takes away, m, shape (samples,)."""
    alone = {name: pool.tried[Pair([name])] for name in names if Pair([name]) in pool.tried}
    return {name: _taken(pool.evidence, base, trial) for name, trial in alone.items()}


def _taken(evidence: Evidence, base: Base, trial: Trial) -> Array:
    """What an effect alone takes away, m, that the base parameters cannot, shape (samples,)."""
    problem = problem_of(evidence, trial.model, trial.free)
    residual = problem.residuals(problem.point(trial.model, trial.initial_hysteresis))
    return Projection(base.basis)(base.residual - residual)


def _left(base: Base, taken: Mapping[str, Array], pair: Sequence[str]) -> float:
    columns = np.column_stack([taken[name] for name in pair])
    sizes = np.linalg.norm(columns, axis=0)
    if not math.isfinite(sizes.sum()) or not sizes.all():
        return math.inf  # an effect that was fitted away, or that diverges
    _, left = nnls(columns / sizes, base.rest)
    return float(left) / math.sqrt(len(base.rest))
