"""A gain that changes slowly: no effect of the library, and what a drift is taken for most.

A stack that ages, a supply that sags, a light that fades change how far the rig goes, not where it
stands. A drift's course is free and follows part of that. So the gain is given a course in its
place, of the same shapes and but one weight more, and the base parameters may go a little of the
way to either: of the two, whichever is at work leaves less.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
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
    Mask,
    Projection,
    courses,
    fit_nuisance,
    largest_hysteresis,
    response,
)
from microgripper_control.plant.model import Key, Model

DRIFT = "thermal_drift"
STEP = 0.01  # of a value, for its derivative


class Followed(NamedTuple):
    """What is left, m rms, where each recording has a drift of its own, or a gain."""

    by_drift: float
    by_gain: float


def followed(evidence: Evidence, trial: Trial) -> Followed:
    """What courses of a drift leave of all recordings, and of a gain, beside a trial with a drift.

    On the samples that are fitted or judge, all of which the courses are fitted to.
    """
    looked_at: dict[int, tuple[Recording, Mask]] = {}
    recordings, masks = (*evidence.fitted, *evidence.judged), (*evidence.used, *evidence.compared)
    for recording, mask in zip(recordings, masks, strict=True):
        _, known = looked_at.get(id(recording), (recording, mask))
        looked_at[id(recording)] = recording, known | mask
    squares, count = np.zeros(2), 0
    for recording, mask in looked_at.values():
        left = list(_left(evidence.conditions, trial, recording, mask))
        squares += [one @ one for one in left]
        count += len(left[0])
    return Followed(*np.sqrt(squares / count).tolist())


def _left(
    conditions: Conditions, trial: Trial, recording: Recording, mask: Mask
) -> Iterator[Array]:
    """The errors, m, of some samples that courses of a drift leave, and of a gain."""
    own = fit_nuisance(trial.model, recording, conditions)
    recording = replace(recording, reading_age=own.reading_age)
    plain, h = trial.model.without([DRIFT]), own.initial_hysteresis

    def answers(changes: Mapping[Key, float], h: float) -> Array:
        return response(plain.with_values(changes), recording, conditions, h)

    answer = answers({}, h)
    turned = [answers({key: value}, h) for key, value in _changed(plain, trial.free)]
    if not conditions.knows_initial_hysteresis:
        turned.append(answers({}, h + STEP * largest_hysteresis(plain, recording)))
    beside = [courses(plain, recording), *_directions(turned, answer)]
    drifts = registry()[DRIFT].courses(trial.model.values(DRIFT), recording.elapsed)
    gains = np.vstack([np.ones_like(answer), drifts]) * answer / np.max(np.abs(answer))
    counted = mask & conditions.answered(recording)
    for shapes in (drifts, gains):
        without = Projection.off(np.vstack([*beside, shapes])[:, counted])
        yield without((recording.measured - answer)[counted])


def _changed(model: Model, free: Sequence[Key]) -> Iterator[tuple[Key, float]]:
    """The base parameters that a fit may change, each with a value close by."""
    for link, name in free:
        value = model.value(link, name)
        other = registry()[link].parameter(name).nearest((1.0 - STEP) * value)
        if registry()[link].nominal and other != value:
            yield (link, name), other


def _directions(turned: Sequence[Array], answer: Array) -> Iterator[Array]:
    """Where changes have taken an answer, of size one; none where they did nothing, or diverged."""
    for other in turned:
        size = float(np.max(np.abs(other - answer)))
        if 0.0 < size < np.inf:
            yield (other - answer) / size
