"""A whole diagnosis: from a model and recordings to the answer."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.answers import answer
from microgripper_control.diagnosis.answers.answer import Weighed
from microgripper_control.diagnosis.answers.colour import coloured_noise
from microgripper_control.diagnosis.answers.comparison import Comparison
from microgripper_control.diagnosis.answers.driven import most_driven
from microgripper_control.diagnosis.answers.sentence import sentence
from microgripper_control.diagnosis.answers.weighing import Facts, weigh
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.data.gaps import cut_at_gaps
from microgripper_control.diagnosis.data.readings import UNCOUNTED, without_dead
from microgripper_control.diagnosis.data.residuals import residuals_of
from microgripper_control.diagnosis.experiments.experiment import next_experiment
from microgripper_control.diagnosis.findings import (
    EFFECTS,
    NONE,
    PARAMETERS,
    Diagnosis,
    NextExperiment,
    Signature,
)
from microgripper_control.diagnosis.fits.courses import sizes
from microgripper_control.diagnosis.fits.fitting import FINE
from microgripper_control.diagnosis.fits.hold_check import hold_warnings
from microgripper_control.diagnosis.fits.identified_model import identified
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.fits.unseen import unseen_gap, unseen_warning
from microgripper_control.diagnosis.search.exploration import alone, together
from microgripper_control.diagnosis.search.finishing import refined
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.refit import nominal_trial, refits
from microgripper_control.diagnosis.search.rounds import Progress, silent
from microgripper_control.diagnosis.signs.freeform import explainable
from microgripper_control.diagnosis.signs.signatures import signatures
from microgripper_control.diagnosis.signs.where import locate
from microgripper_control.effects.base import no_starts
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.range_check import range_warnings
from microgripper_control.identification.scale_check import scale_warnings
from microgripper_control.plant.model import Model

SILENT = 1e-6  # of the stroke: with less noise a rig's own readings may be equal


def candidate_names() -> list[str]:
    """The effects that a diagnosis tries, in the order of the chain."""
    return [name for name, link in registry().items() if link.starts is not no_starts]


@dataclass(frozen=True)
class _Explored:
    """What was tried, and on which evidence; `lean` is as much of the whole as is compared."""

    whole: Evidence
    lean: Evidence
    nominal: Trial
    pool: Pool
    warnings: Sequence[str]


@dataclass(frozen=True)
class _Answer:
    """The verdict, and the trial and the model that it stands for."""

    weighed: Weighed
    verdict: str
    effects: tuple[str, ...]
    best: Trial
    model: Model
    slow_gain: bool  # whether that would explain much


def diagnose(
    nominal: Model,
    recordings: Sequence[Recording],
    heldout: Sequence[Recording] = (),
    conditions: Conditions | None = None,
    progress: Progress = silent,
    jobs: int = -1,
    without: Collection[str] = (),
) -> Diagnosis:
    """Explain how the rig on the recordings differs from `nominal`, judged on `heldout` if given.

    The effects in `without` are not tried. Readings that a dead or clipped sensor repeats do not
    count where an effect is found; where none is, they are a gap that no effect explains. Raises
    MicrogripperError for recordings that tell nothing.
    """
    beyond = range_warnings(nominal, [*recordings, *heldout])
    pieces = cut_at_gaps(recordings, heldout, conditions or Conditions())
    recordings, heldout, conditions = pieces.recordings, pieces.heldout, pieces.conditions
    alive, alive_heldout = without_dead(recordings), without_dead(heldout)
    lines = [*beyond, *pieces.lines, *alive.lines, *alive_heldout.lines]
    whole = Evidence.gather(alive.recordings, alive_heldout.recordings, conditions, nominal)
    found = _diagnosed(nominal, whole, lines, progress, jobs, without)
    if found.verdict in (NONE, PARAMETERS) and (alive.left_out or alive_heldout.left_out):
        whole = Evidence.gather(recordings, heldout, conditions, nominal)
        lines = [line.removesuffix(UNCOUNTED) for line in lines]
        # What a rig does shows its noise: a stop that it meets gives no equal readings.
        noisy = found.gap.noise_floor > SILENT * max(np.ptp(r.measured) for r in recordings)
        left_out = candidate_names() if noisy else without
        found = _diagnosed(nominal, whole, lines, progress, jobs, left_out)
    return found


def _diagnosed(
    nominal: Model,
    whole: Evidence,
    warnings: Sequence[str],
    progress: Progress,
    jobs: int,
    without: Collection[str],
) -> Diagnosis:
    """The diagnosis from evidence; `warnings` are of its readings."""
    left_out = {*nominal.effects, *without}
    names = [name for name in candidate_names() if name not in left_out]
    explored = _explored(whole, names, progress, jobs)
    progress("where the gap lies", 0, 1)
    pool = explored.pool
    pool.coloured = coloured_noise(pool)
    left = residuals_of(pool.evidence, pool.refit.model)
    signs = signatures(left.each_once, pool.noise_floor)
    given = _answer(explored, signs)
    found = answer.candidates(given.weighed, pool, names, signs, given.model)
    compared = Comparison.of(
        explored.whole, explored.lean, explored.nominal, pool.refit, given.best
    )
    model = given.model.with_rounding_of(nominal)
    free_form = explainable(left.fitted, left.judging, pool.noise_floor)
    driver = most_driven(found)
    gap = replace(
        compared.gap(pool.noise_floor, free_form),
        driver=driver.effect if driver else "",
        by_driver=driver.share if driver else 0.0,
        unseen=bool(explored.warnings),
    )
    where = tuple(locate(left.each_once, pool.noise_floor))
    groups = answer.ambiguous(given.weighed, pool) if given.verdict == EFFECTS else ()
    told = sentence(
        given.verdict,
        given.effects,
        gap,
        nominal,
        model,
        found,
        where,
        pool.evidence.scales,
        groups,
        sizes(pool.evidence, given.best),
        given.slow_gain,
    )
    return Diagnosis(
        verdict=given.verdict,
        sentence=told,
        effects=given.effects,
        candidates=found,
        stages=answer.stages(found),
        gap=gap,
        where=where,
        ambiguous=groups,
        next_experiment=_next(given.weighed, pool),
        nominal=nominal,
        refit=compared.refit.model,
        model=model,
        conditions=whole.conditions,
        judged=compared.judged(left.zero),
        shares=_shares(pool, given.effects, given.best),
        warnings=(
            *warnings,
            *scale_warnings(whole.nominal, pool.evidence.fitted, whole.conditions),
            *explored.warnings,
            *hold_warnings(pool.evidence, pool.refit),
        ),
    )


def _explored(
    whole: Evidence,
    names: Sequence[str],
    progress: Progress,
    jobs: int,
    warnings: Sequence[str] = (),
) -> _Explored:
    """Try the effects; a gap that only shows where it is judged is, once, fitted on half of that.

    Of blocks that goes for the effect that fits best as well: it may hide where a second shows.
    """

    def on_more(unseen: Trial) -> _Explored:
        told = [unseen_warning(whole, unseen)]
        return _explored(whole.joined(), names, progress, jobs, told)

    lean, before, refitted = _without_effects(whole)
    if not warnings and unseen_gap(whole, refitted[0]):
        return on_more(refitted[0])
    pool = alone(lean, before, refitted, names, progress, jobs)
    if not warnings and not whole.separate and unseen_gap(pool.evidence, pool.closest):
        return on_more(pool.closest)
    pool = together(pool, names, progress, jobs)
    return _Explored(whole, lean, before, pool, warnings)


def _without_effects(whole: Evidence) -> tuple[Evidence, Trial, Sequence[Trial]]:
    """As much evidence as is compared; on it the nominal model as it is, and its refits."""
    lean = whole.lean()
    before = nominal_trial(lean, whole.nominal)
    return lean, before, refits(lean, before)


def _answer(explored: _Explored, signs: Sequence[Signature]) -> _Answer:
    """What is most probable; the effects of an answer are fitted to the end."""
    pool = explored.pool
    facts = Facts.of(pool, signs)
    weighed = weigh(facts)
    verdict = answer.verdict(weighed, pool)
    if verdict == NONE:
        return _Answer(weighed, verdict, (), explored.nominal, explored.whole.nominal, False)
    effects: tuple[str, ...] = ()
    best = pool.refit
    if verdict == EFFECTS:
        chosen = answer.chosen(weighed, pool)
        effects = answer.by_importance(chosen, pool)
        pool.add(refined(pool.evidence, pool.tried[chosen], FINE, 20))
        best = pool.tried[chosen]  # the last fit, unless it does worse: it may diverge
    model = identified(pool.evidence, best)
    return _Answer(weighed, verdict, effects, best, model, facts.slow_gain)


def _next(weighed: Weighed, pool: Pool) -> NextExperiment | None:
    """The experiment that would best tell the most probable explanations apart."""
    rivals = [trial.model for trial in answer.rivals(weighed, pool)]
    evidence = pool.evidence
    return next_experiment(rivals, evidence.fitted[0], evidence.conditions, pool.noise_floor)


def _shares(pool: Pool, effects: Sequence[str], best: Trial) -> Mapping[str, float]:
    """Of what the effects close together: the part that goes when one is left out."""
    if len(effects) < 2:
        return dict.fromkeys(effects, 1.0)
    lost = {}
    for name in effects:
        without = pool.tried.get(frozenset(effects) - {name})
        lost[name] = max(0.0, without.rmse**2 - best.rmse**2) if without else 0.0
    total = sum(lost.values())
    return {name: part / total if total > 0.0 else 0.0 for name, part in lost.items()}
