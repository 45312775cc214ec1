"""Lags tried again on the clock of the sensor that they show.

Before the clock is known the lags may each suggest another, and how long a lag is misleads: each is
fitted with each likely clock, which is then looked for more closely.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.fitting import Base
from microgripper_control.diagnosis.part import POLISHED, refined
from microgripper_control.diagnosis.pool import Pool
from microgripper_control.diagnosis.rounds import Progress, play, silent
from microgripper_control.diagnosis.sensor_clock import has_clock, on_its_clocks, retimed
from microgripper_control.diagnosis.trial import Trial, unfitted
from microgripper_control.identification.reading_age import DELAY
from microgripper_control.plant.model import Key

AS_GOOD = 1.1  # times what the best leaves: a lag that leaves more is not the cause


def on_the_sensors_clock(bases: Sequence[Base], pool: Pool, progress: Progress, jobs: int) -> Pool:
    """The pool, with the sensor's clock if there is one; the lags are then tried with it."""
    best = pool.best(1, len(pool.tried))
    lags = [trial for trial in best if has_clock(trial)]
    if not lags or lags[0].both > AS_GOOD * best[0].both or not pool.leaves_more(best[0]):
        return pool
    timed = [pool]
    for lag in lags:
        for evidence, ahead in on_its_clocks(pool.evidence, lag):
            rough = _on(evidence, pool)
            play(evidence, bases, _added(lag, pool), 1, rough, silent, jobs)
            if DELAY in lag.effects:
                delay = max(0.0, lag.model.value(DELAY, "delay") - ahead)
                rough.add(_fitted(lag, {(DELAY, "delay"): delay}, rough))
            timed += [rough, *_closer(lag, rough, pool)]
    chosen = min(timed, key=lambda pool: pool.best(1, 1)[0].both)
    if chosen is not pool:
        names = [name for lag in lags for name in _added(lag, pool)]
        play(chosen.evidence, bases, names, len(names), chosen, progress, jobs)
    return chosen


def _on(evidence: Evidence, pool: Pool) -> Pool:
    """A pool on other evidence."""
    return replace(pool, evidence=evidence, tried={**pool.tried})


def _added(lag: Trial, pool: Pool) -> list[str]:
    return [name for name in lag.effects if name not in pool.own]


def _closer(lag: Trial, rough: Pool, pool: Pool) -> list[Pool]:
    """The pool with a closer clock than a rough one has, if the lag took that."""
    names = _added(lag, pool)
    trial = rough.tried[frozenset(names)]
    if trial.model.clock == 0.0:
        return []
    closer = _on(retimed(rough.evidence, trial), pool)
    closer.add(_fitted(trial, {}, closer))
    return [closer]


def _fitted(lag: Trial, values: Mapping[Key, float], pool: Pool) -> Trial:
    """A lag fitted on with the clock of a pool's evidence, from some other values."""
    evidence = pool.evidence
    clocks = {(name, "clock"): evidence.scales.clock for name in _added(lag, pool)}
    trial = replace(lag, model=lag.model.with_values({**values, **clocks}))
    return refined(evidence, unfitted(evidence, trial), POLISHED, 60)
