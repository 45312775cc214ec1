"""A gain that changes slowly: no effect of the library, and what a drift is taken for most.

A stack that ages, a supply that sags, a light that fades change how far the rig goes, not where it
stands. A drift's course is free and follows part of that. So the gain is given a course in its
place, of the same shapes and but one weight more, and the base parameters may go a little of the
way to either: of the two, whichever is at work leaves less.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import (
    Conditions,
    Nuisance,
    Projection,
    courses,
    fit_nuisance,
    largest_hysteresis,
    response,
)
from microgripper_control.plant.model import Model

DRIFT = "thermal_drift"
STEP = 0.01  # of a value, for its derivative


class Followed(NamedTuple):
    """What is left, m rms, where each recording has a drift of its own, or a gain."""

    by_drift: float
    by_gain: float


def followed(evidence: Evidence, trial: Trial) -> Followed:
    """What courses of a drift leave of all recordings, and of a gain, beside a trial with a drift.

    On the samples that they are fitted to; neither foretells anything.
    """
    recordings = {id(one): one for one in (*evidence.fitted, *evidence.judged)}
    squares, count = np.zeros(2), 0
    for recording in recordings.values():
        counted = evidence.conditions.answered(recording)
        squares += [left @ left for left in _left(evidence.conditions, trial, recording)]
        count += int(np.count_nonzero(counted))
    return Followed(*np.sqrt(squares / count).tolist())


def _left(conditions: Conditions, trial: Trial, recording: Recording) -> Iterator[Array]:
    """The errors, m, of the counted samples that courses of a drift leave, and of a gain."""
    counted = conditions.answered(recording)
    own = fit_nuisance(trial.model, recording, conditions)
    recording = replace(recording, reading_age=own.reading_age)
    plain = trial.model.without([DRIFT])
    answer = response(plain, recording, conditions, own.initial_hysteresis)
    error = (recording.measured - answer)[counted]
    time = np.asarray(recording.sample_period * np.arange(len(recording)), dtype=np.float64)
    drifts = registry()[DRIFT].courses(trial.model.values(DRIFT), time)
    gains = np.vstack([np.ones_like(answer), drifts]) * answer / np.max(np.abs(answer))
    others = [courses(plain, recording), *_turns(plain, trial, recording, conditions, own, answer)]
    for shapes in (drifts, gains):
        yield Projection.off(np.vstack([*others, shapes])[:, counted])(error)


def _turns(
    plain: Model,
    trial: Trial,
    recording: Recording,
    conditions: Conditions,
    own: Nuisance,
    answer: Array,
) -> Iterator[Array]:
    """Where the base parameters and an unknown first h take the answer, about 1, shape (n,)."""
    h = own.initial_hysteresis
    others = []
    for link, name in trial.free:
        value, parameter = plain.value(link, name), registry()[link].parameter(name)
        changed = parameter.nearest((1.0 - STEP) * value)
        if registry()[link].nominal and changed != value:
            model = plain.with_values({(link, name): changed})
            others.append(response(model, recording, conditions, h))
    if not conditions.knows_initial_hysteresis:
        h += STEP * largest_hysteresis(plain, recording)
        others.append(response(plain, recording, conditions, h))
    for other in others:
        turn = other - answer
        size = float(np.max(np.abs(turn)))
        if 0.0 < size < np.inf:
            yield turn / size
