"""Whether a fit did what its effect's law says, or what belongs to each recording did it instead.

The courses of a link are weighed freely, recording by recording: creep that was not complete when
one began would pass for any drift.
"""

from __future__ import annotations

from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.trial import Trial
from microgripper_control.effects.base import always_credible
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import fit_nuisance, own_courses


def incredible(evidence: Evidence, trial: Trial) -> list[str]:
    """The effects of a trial whose own courses are larger than their law allows."""
    doubted = [n for n in trial.effects if registry()[n].credible is not always_credible]
    if not doubted:
        return []
    found = set()
    for recording, used in zip(evidence.fitted, evidence.used, strict=True):
        nuisance = fit_nuisance(trial.model, recording, evidence.conditions, used)
        own = own_courses(trial.model, recording, nuisance)
        for name in doubted:
            values = trial.model.values(name)
            if name in own and not registry()[name].credible(values, own[name], evidence.scales):
                found.add(name)
    return sorted(found)
