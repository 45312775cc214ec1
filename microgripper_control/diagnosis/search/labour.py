"""What a fit costs: how many rows of coefficients a sample takes.

A force is balanced within each sample, many times where the mass rings or the way counts, and all
that many times over where a band-limited voltage bends.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import ROWS
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial, added, with_guess
from microgripper_control.effects.registry import registry
from microgripper_control.plant.bandlimited import course
from microgripper_control.plant.chain import Chain
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial

MOST_ROWS = 2e7  # of coefficients in a simulation with forces: what makes it longer does not join
LONG_ROWS = 2e6  # the same: a round of further effects then takes some ten minutes
PART_ROWS = 1e6  # the same: a part of the samples is fitted first then
MANY_ROWS = 10  # of coefficients a sample: by place, and at rest at its end, a force takes five


def is_light_with(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """Whether a trial's model with one more effect takes few rows of coefficients a sample."""
    model = _with(evidence, trial, effect)
    return model is None or max(_labour(evidence, model).values()) <= MANY_ROWS


def is_force(effect: str) -> bool:
    """Whether an effect is a force, which is balanced within each sample."""
    return registry()[effect].force is not None


def is_costly(evidence: Evidence, model: Model) -> bool:
    """Whether a model has forces that are balanced many times in each sample."""
    return max(_labour_of_forces(evidence, model)) > MANY_ROWS


def is_long(evidence: Evidence, model: Model) -> bool:
    """Whether a simulation of a model with such forces takes a good part of a tenth of a second."""
    return _rows(evidence, model) > LONG_ROWS


def is_long_with(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """The same of a trial's model with one more effect, at its first start."""
    return _rows_with(evidence, trial, effect) > LONG_ROWS


def is_costly_with(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """Whether a trial's model has such forces with one more effect, at its first start."""
    model = _with(evidence, trial, effect)
    return model is not None and is_costly(evidence, model)


def is_laborious_with(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """Whether it takes too long to fit a trial's model with one more effect to all samples."""
    return _rows_with(evidence, trial, effect) > PART_ROWS


def may_join(evidence: Evidence, trial: Trial, effect: str) -> bool:
    """Whether an effect may be added to a trial's: a costly force beside two would take minutes.

    Beside one it may, unless a simulation then takes half a second, so often are they balanced.
    """
    model = _with(evidence, trial, effect)
    if model is None or not is_costly(evidence, model):
        return True
    return len(added(evidence, trial)) < 2 and _rows(evidence, model) <= MOST_ROWS


def _rows(evidence: Evidence, model: Model) -> int:
    """Rows of coefficients that a simulation of all recordings takes; 0 without any force."""
    labour = _labour_of_forces(evidence, model)
    return sum(len(one) * rows for one, rows in zip(evidence.fitted, labour, strict=True))


def _rows_with(evidence: Evidence, trial: Trial, effect: str) -> int:
    """The same of a trial's model with one more effect, at its first start; 0 if it has none."""
    model = _with(evidence, trial, effect)
    return 0 if model is None else _rows(evidence, model)


def _with(evidence: Evidence, trial: Trial, effect: str) -> Model | None:
    """A trial's model with one more effect, at its first start; None if that has none."""
    starts = registry()[effect].starts(evidence.scales)
    return with_guess(trial.model, effect, starts[0]) if starts else None


def _labour_of_forces(evidence: Evidence, model: Model) -> list[int]:
    """Rows of coefficients that a sample of each recording takes with forces; 0 without any."""
    if not any(map(is_force, model.effects)):
        return [0] * len(evidence.fitted)
    labour = _labour(evidence, model)
    return [_divisions(evidence, one) * labour[one.sample_period] for one in evidence.fitted]


def _divisions(evidence: Evidence, recording: Recording) -> int:
    """Into how many a sample period is divided as the voltage bends within it."""
    if evidence.conditions.hold is not Hold.BANDLIMITED:
        return 1
    periodic = evidence.conditions.initial is Initial.PERIODIC
    return course(recording.voltage, periodic).divisions


def _labour(evidence: Evidence, model: Model) -> dict[float, int]:
    """Rows of coefficients a sample of a model takes, by sample period, s, of which few differ."""
    periods, hold = {one.sample_period for one in evidence.fitted}, evidence.conditions.hold
    return {one: Chain(model, one, np.zeros(ROWS), hold=hold).labour for one in periods}
