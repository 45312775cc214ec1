"""Whether a fit did what its effect's law says, or what belongs to each recording did it instead.

The courses of a link are weighed freely, recording by recording: creep that was not complete when
one began would pass for any drift.
"""

from __future__ import annotations

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.courses import fitted_courses
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.effects.base import always_credible
from microgripper_control.effects.registry import registry


def incredible(evidence: Evidence, trial: Trial) -> str:
    """An effect of a trial whose own courses are larger than its law allows; empty if none is."""
    if all(registry()[name].credible is always_credible for name in trial.effects):
        return ""
    for name, course in fitted_courses(evidence, trial):
        if not registry()[name].credible(trial.model.values(name), course, evidence.scales):
            return name
    return ""
