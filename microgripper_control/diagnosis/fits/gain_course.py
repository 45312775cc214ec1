"""A gain that changes slowly: no effect of the library, and what a drift is taken for most.

A stack that ages, a supply that sags, a light that fades change how far the rig seems to go, not
where it stands. A drift's course is free and follows part of that. So the gain is given a course in
its place, of the same shapes and but one weight more: of the two, whichever is at work leaves less.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import (
    Projection,
    courses,
    fit_nuisance,
    response,
    zero_of,
)

DRIFT = "thermal_drift"


def gain_over_drift(evidence: Evidence, trial: Trial) -> float:
    """What a course of the gain leaves over what the drift of a trial does, m rms over m rms.

    Of all recordings, each with courses of its own, with the other values as the trial has them.
    """
    recordings = {id(one): one for one in (*evidence.fitted, *evidence.judged)}
    left = [_left(evidence, trial, recording) for recording in recordings.values()]
    drift, gain = np.sum(left, axis=0)
    return float(np.sqrt(gain / drift)) if drift > 0.0 else 1.0


def _left(evidence: Evidence, trial: Trial, recording: Recording) -> Array:
    """The sums of squares, m^2, that courses of drift and of gain leave of a recording."""
    conditions, model = evidence.conditions, trial.model
    nuisance = fit_nuisance(model, recording, conditions)
    timed = replace(recording, reading_age=nuisance.reading_age)
    plain = model.without([DRIFT])
    counted = conditions.answered(recording)
    error = recording.measured - response(plain, timed, conditions, nuisance.initial_hysteresis)
    time = np.asarray(recording.sample_period * np.arange(len(recording)), dtype=np.float64)
    drifts = registry()[DRIFT].courses(model.values(DRIFT), time)
    position = recording.measured - zero_of(model, nuisance)
    gains = np.vstack([np.ones_like(position), drifts]) * position / np.max(np.abs(position))
    others = courses(plain, recording)
    left = [
        Projection.off(np.vstack([others, shapes])[:, counted])(error[counted])
        for shapes in (drifts, gains)
    ]
    return np.array([rest @ rest for rest in left])
