"""What belongs to each recording by itself: creep from before it began, drift, hum."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import fit_nuisance, own_courses


def fitted_courses(evidence: Evidence, trial: Trial) -> Iterator[tuple[str, Array]]:
    """The effects of a trial that have a course in a fitted recording, and it, where used, m."""
    model, conditions = trial.model, evidence.conditions
    for recording, used in zip(evidence.fitted, evidence.used, strict=True):
        nuisance = fit_nuisance(model, recording, conditions, used)
        for name, (weights, shapes) in own_courses(model, recording, nuisance).items():
            yield name, (weights @ shapes)[conditions.answered(recording) & used]


def sizes(evidence: Evidence, trial: Trial) -> dict[str, float]:
    """How large the random effects of a trial are in the fitted recordings, m rms about a mean."""
    found: dict[str, list[Array]] = {}
    if any(registry()[name].random for name in trial.effects):
        for name, course in fitted_courses(evidence, trial):
            if registry()[name].random:
                found.setdefault(name, []).append(course - np.mean(course))
    return {name: rms(each) for name, each in found.items()}
