"""What a force with a memory holds when a recording begins.

The way there is told by h (`effects.past`). Whether the wait after it leaves the force what it held
is another matter: the recordings decide, all of them together.
"""

from __future__ import annotations

from dataclasses import replace

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import ROUGH, fit_on
from microgripper_control.diagnosis.fits.trial import Trial, judged, moved, unfitted
from microgripper_control.effects.memory_of_the_way import RELEASED
from microgripper_control.effects.registry import registry
from microgripper_control.plant.simulate import Initial

STEPS = 6  # of the fit that begins from nothing


def begun_from_nothing(evidence: Evidence, trial: Trial, name: str) -> Trial:
    """The trial with an effect that holds nothing at first, if that leaves less; judged, as it is.

    It is compared before it is fitted on.
    """
    remembers = RELEASED in registry()[name].parameters
    if not remembers or evidence.conditions.initial is not Initial.FIRST_SAMPLE:
        return trial
    model = trial.model.with_values({(name, RELEASED.name): 1.0})
    other = unfitted(evidence, moved(evidence, replace(trial, model=model)))
    if not other.fitted_rmse < trial.fitted_rmse:
        return trial
    return judged(evidence, fit_on(evidence, other, ROUGH, STEPS, fresh=[name]))
