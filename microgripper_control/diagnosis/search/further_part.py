"""A further part of a law, which only a fit without it can suggest: the second mode of a mount."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import Base, base_of, begun
from microgripper_control.diagnosis.fits.trial import Trial, added, problem_of, with_guess
from microgripper_control.diagnosis.search.finishing import POLISHED, refined
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.schedule import side_by_side
from microgripper_control.diagnosis.search.screening import Guess, judge
from microgripper_control.effects.base import no_more
from microgripper_control.effects.registry import registry

FITTED, EVALUATIONS = 2, 40  # first guesses, and how long they are fitted
WORTH = 0.9  # of what is left without: a further part that leaves more is none


def add_further_parts(pool: Pool, jobs: int) -> None:
    """Try the further part of each law in what leaves the least, if that is more than noise."""
    leader = pool.leader
    if not pool.leaves_more(leader):
        return
    names = [name for name in added(pool.evidence, leader) if registry()[name].more is not no_more]
    tasks = [(pool.evidence, leader, name) for name in sorted(names)]
    for trials in side_by_side(_with_more, tasks, jobs):
        for trial in trials:
            if trial.both < WORTH * leader.both:
                pool.add(trial)


def _with_more(evidence: Evidence, trial: Trial, name: str) -> list[Trial]:
    """The fits from the guesses that promise most."""
    base = base_of(evidence, trial)
    guesses = sorted(_guesses(evidence, base, name), key=lambda guess: guess.least)
    starts = [begun(base, guess.model, [name]) for guess in guesses[:FITTED]]
    return [refined(evidence, start, POLISHED, EVALUATIONS) for start in starts]


def _guesses(evidence: Evidence, base: Base, name: str) -> Iterator[Guess]:
    """What the law with its further part promises, that part as strong as fits best."""
    link, own = registry()[name], base.trial.model.values(name)
    problem = problem_of(evidence, base.trial.model, base.trial.free)
    for part in link.more(own, evidence.scales):
        weak = with_guess(base.trial.model, name, {**own, **part})
        guess = judge(replace(problem, model=weak), base, name)
        if guess is not None:
            scaled = {
                key: guess.strength * value
                for key, value in part.items()
                if link.parameter(key).vanishing == 0.0
            }
            yield replace(guess, model=with_guess(weak, name, {**own, **part, **scaled}))
