"""Lags tried again on the clock of the sensor that they show.

Before the clock is known the lags may each suggest another, and how long a lag is misleads: each is
fitted with each likely clock, and the best clock is then looked for more closely.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import (
    Trial,
    added,
    fitted_keys,
    unfitted,
    with_guess,
)
from microgripper_control.diagnosis.search.finishing import POLISHED, refined
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.schedule import side_by_side
from microgripper_control.diagnosis.search.sensor_clock import on_its_clocks, retimed
from microgripper_control.effects.registry import registry
from microgripper_control.identification.reading_age import DELAY, can_be_late
from microgripper_control.plant.model import Model

NO_CAUSE = 2.0  # times what the best leaves: a lag that leaves more without a clock is none,
LAGS = 2  # explanations with a lag that are looked at,
AS_GOOD = 1.1  # times what the best clock leaves: those that leave less are looked for more closely
FITTED, EVALUATIONS = 2, 25  # first guesses of a lag with a clock, and how long they are fitted

Lag = tuple[Trial, Evidence, float]  # what explains it by a mean lag, too long by the last, s


def on_the_sensors_clock(pool: Pool, jobs: int = -1, size: int = 1) -> Pool:
    """The pool, with the sensor's clock if there is one; the lags are then tried with it.

    They are looked for among the explanations by `size` effects: what else the rig does may hide a
    clock from a lag by itself.
    """
    best = pool.best(size, len(pool.tried))
    period = max(recording.sample_period for recording in pool.evidence.fitted)
    lags = [
        trial
        for trial in best
        if len(_clocked(trial, pool.evidence)) == 1 and can_be_late(trial.model, period)
    ][:LAGS]
    known = max(pool.nominal.model.clock, pool.evidence.scales.clock)
    if known > 0.0 or not lags or not pool.leaves_a_rest(best[0]):
        return pool
    if lags[0].both > NO_CAUSE * best[0].both:
        return pool
    rough = [(lag, *timed) for lag in lags for timed in on_its_clocks(pool.evidence, lag)]
    tried = _fitted(rough, jobs)
    least = min((fit.trial.both for fit in tried), default=0.0)
    near = [fit for fit in tried if fit.trial.both < AS_GOOD * least]
    tried += _fitted([(fit.trial, *retimed(fit.evidence, fit.trial)) for fit in near], jobs)
    chosen = min(tried, key=lambda fit: fit.trial.both, default=None)
    if chosen is None or chosen.trial.both >= best[0].both:
        return pool
    pool = replace(pool, evidence=chosen.evidence, tried={**pool.tried}, joined=set())
    others = [lag for lag in lags if lag.effects != chosen.trial.effects]
    for fit in (chosen, *_fitted([(lag, chosen.evidence, 0.0) for lag in others], jobs)):
        pool.add(fit.trial)
    return pool


class Fit(NamedTuple):
    """A lag fitted on evidence that has a clock."""

    trial: Trial
    evidence: Evidence


def _fitted(lags: Sequence[Lag], jobs: int) -> list[Fit]:
    found = dict(side_by_side(_numbered, list(enumerate(lags)), jobs))
    return [Fit(found[number], lag[1]) for number, lag in enumerate(lags)]


def _numbered(number: int, lag: Lag) -> tuple[int, Trial]:
    return number, _on_clock(*lag)


def _on_clock(lag: Trial, evidence: Evidence, ahead: float) -> Trial:
    """A lag, too long by `ahead`, s, fitted with the sensor's clock from its likeliest guesses."""
    (name,) = _clocked(lag, evidence)
    others = [key for key in lag.free if key[0] != name]
    guesses = []
    for model in _guesses(lag, name, evidence, ahead):
        free = (*others, *fitted_keys(model, [name]))
        guesses.append(unfitted(evidence, replace(lag, model=model, free=free, errors=())))
    guesses.sort(key=lambda trial: trial.fitted_rmse)
    fits = [refined(evidence, guess, POLISHED, EVALUATIONS) for guess in guesses[:FITTED]]
    return min(fits, key=lambda trial: trial.both)


def _clocked(trial: Trial, evidence: Evidence) -> list[str]:
    """The effects that a trial adds and that may read on a clock of the sensor's own."""
    return [name for name in sorted(added(evidence, trial)) if registry()[name].clocked]


def _guesses(lag: Trial, name: str, evidence: Evidence, ahead: float) -> Iterator[Model]:
    """Models to begin with: the lag's own, and each of its first guesses that has the clock."""
    own = lag.model.with_values({(name, "clock"): evidence.scales.clock})
    if name == DELAY:
        delay = max(0.0, own.value(name, "delay") - ahead)
        own = own.with_values({(name, "delay"): delay})
    yield own
    for values in registry()[name].starts(evidence.scales):
        if values.get("clock", 0.0) > 0.0:
            yield with_guess(lag.model, name, values)
