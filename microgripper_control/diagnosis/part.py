"""Less to look at where each sample is dear.

A force is balanced within each sample, many times where the mass rings or the way counts. It knows
place and way and not the time, so stretches of the recordings show enough of it to begin with.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from microgripper_control.core.signals import ROWS
from microgripper_control.diagnosis.evidence import Evidence, rms
from microgripper_control.diagnosis.fitting import Base, base_of, fit_on, refine
from microgripper_control.diagnosis.noise import innovation, removable
from microgripper_control.diagnosis.trial import Trial, judged_once, moved
from microgripper_control.effects.registry import registry
from microgripper_control.plant.chain import Chain
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Hold


class Effort(NamedTuple):
    """How far a round of a fit goes, and of what was left before it it must leave less to go on."""

    tolerance: float
    evaluations: int
    worth_another: float


PART = 15_000  # samples that are fitted then
WORTHWHILE = 2.0  # times that many, at least, or all are fitted
HIDDEN = 0.3  # of the gap: a part that shows less of it is no part to look at
GLANCE = 6000  # samples on which it is seen what a force promises
MANY = 40_000  # samples
MOST_ROWS = 2e7  # of coefficients in a simulation with forces: what makes it longer does not join
MANY_ROWS = 10  # of coefficients a sample: by place, and at rest at its end, a force takes five
POLISHED = 1e-5  # tolerance
TO_THE_END, ENOUGH = Effort(POLISHED, 20, 0.99), Effort(1e-3, 8, 0.9)
ROUNDS = 3


def on_a_part(
    evidence: Evidence, bases: Sequence[Base], name: str, most: int
) -> tuple[Evidence, Sequence[Base]]:
    """What to try an effect on and the bases there: with a dear force, about `most` samples.

    For a glance that goes for any force, and for a play. Less than twice as many are left whole: a
    stretch forgets what was before it, and its fit may lead astray. So are all where the stretches,
    each with a zero and a beginning of its own, show too little of the gap.
    """
    less = is_dear_with(evidence, bases[0].trial, name) or (most <= GLANCE and _is_shown(name))
    less = less and sum(len(recording) for recording in evidence.fitted) > WORTHWHILE * most
    part = evidence.pieces(most) if less else evidence
    if part is evidence:
        return evidence, bases
    anchors = [base_of(part, moved(part, base.trial)) for base in bases]
    return (evidence, bases) if _hides(anchors[0], bases[0]) else (part, anchors)


def _hides(part: Base, whole: Base) -> bool:
    """Whether a part of the samples shows little of what all show."""
    floor = innovation([whole.residual])
    seen, there = (removable(rms([base.residual]), floor) for base in (part, whole))
    return seen < HIDDEN * there


def refined(evidence: Evidence, trial: Trial, tolerance: float, evaluations: int) -> Trial:
    """Fit on and judge what comes out; with a dear force in rounds, with fewer derivatives.

    Those by the base parameters are taken once, or once a round. A dear force by itself, and few
    samples, are fitted to the end: it bends while it is fitted, and gets there late.
    """
    if not is_dear(evidence, trial.model):
        return refine(evidence, trial, tolerance, evaluations)
    few = sum(len(recording) for recording in evidence.fitted) <= MANY
    effort = TO_THE_END if few and len(trial.effects) == 1 else ENOUGH
    for _ in range(ROUNDS):
        before = trial.fitted_rmse
        trial = fit_on(evidence, trial, effort.tolerance, effort.evaluations, fresh=trial.effects)
        if trial.fitted_rmse > effort.worth_another * before:
            break
    return judged_once(evidence, trial)


def is_light_with(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """Whether a trial's model with one more effect takes few rows of coefficients a sample."""
    model = _with(evidence, trial, effect)
    return model is None or _labour(evidence, model) <= MANY_ROWS


def is_force(effect: str) -> bool:
    """Whether an effect is a force, which is balanced within each sample."""
    return registry()[effect].force is not None


def _is_shown(effect: str) -> bool:
    """Whether stretches show an effect."""
    return is_force(effect) or registry()[effect].of_the_way


def is_dear(evidence: Evidence, model: Model) -> bool:
    """Whether a model has forces that are balanced many times in each sample."""
    return _labour_of_forces(evidence, model) > MANY_ROWS


def is_dear_with(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """The same of a trial's model with one more effect, at its first start."""
    model = _with(evidence, trial, effect)
    return model is not None and is_dear(evidence, model)


def may_join(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """Whether an effect may be added to a trial's: a dear force beside two would take minutes.

    Beside one it may, unless forces are then balanced so often that one simulation takes a second.
    """
    model = _with(evidence, trial, effect)
    labour = _labour_of_forces(evidence, model) if model is not None else 0
    if labour <= MANY_ROWS:
        return True
    samples = sum(len(recording) for recording in evidence.fitted)
    return len(trial.effects) < 2 and samples * labour <= MOST_ROWS


def _with(evidence: Evidence, trial: Trial, effect: str) -> Model | None:
    """A trial's model with one more effect, at its first start; None if that has none."""
    starts = registry()[effect].starts(evidence.scales)
    return trial.model.with_link(effect, **starts[0]) if starts else None


def _labour_of_forces(evidence: Evidence, model: Model) -> int:
    """Rows of coefficients a sample of a model with forces takes; 0 without any."""
    return _labour(evidence, model) if any(map(is_force, model.effects)) else 0


def _labour(evidence: Evidence, model: Model) -> int:
    """Rows of coefficients a sample of a model takes."""
    ramped = evidence.conditions.hold is not Hold.ZERO
    return Chain(model, evidence.scales.sample_period, np.zeros(ROWS), ramped=ramped).labour
