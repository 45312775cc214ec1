"""A rig that rings between its samples, and at which of several frequencies.

After a step of a held voltage the mass rings at a frequency f that may lie above half the sampling
rate. The samples then show much the same at |f - k fs|, and a fit that starts a tenth away from f
ends somewhere between. So the natural frequency is looked for over a band about the model's, and
where several fit about as well an unmodelled effect decides which is right: all of them are kept.
"""

from __future__ import annotations

import math

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import ROUGH, Indices, fit_on
from microgripper_control.diagnosis.fits.trial import Trial, judged, unfitted
from microgripper_control.diagnosis.search.finishing import STEPS
from microgripper_control.effects.mass_under_forces import natural_frequency, rings_on
from microgripper_control.identification.determined import DYNAMIC
from microgripper_control.plant.model import Model

BAND = 1.5  # times the model's frequency, up and down: a rig is its model's, mistuned
GRID = 41  # frequencies in it
VALLEYS = 3  # of the residual over the band that are fitted, the deepest
SAME = 0.02  # relative distance of two frequencies that are one
WORSE = 1.5  # times what the best leaves: no rival


def other_frequencies(evidence: Evidence, refit: Trial) -> list[Trial]:
    """The refit begun at other natural frequencies, judged; none twice."""
    if not _rings(evidence, refit):
        return []
    band = pace(evidence.nominal) * np.geomspace(1.0 / BAND, BAND, GRID)
    begun = [unfitted(evidence, _ringing_at(refit, float(f))) for f in band]
    left = np.array([trial.fitted_rmse for trial in begun])
    valleys = sorted((begun[i] for i in _valleys(left)), key=lambda trial: trial.fitted_rmse)
    found: list[Trial] = []
    for start in valleys[:VALLEYS]:
        fit = fit_on(evidence, start, ROUGH, STEPS)
        at = pace(fit.model)
        known = (pace(one.model) for one in (refit, *found))
        if all(abs(at / f - 1.0) > SAME for f in known):
            found.append(judged(evidence, fit))
    least = min(trial.both for trial in (refit, *found))
    return [trial for trial in found if trial.both < WORSE * least]


def pace(model: Model) -> float:
    """The natural frequency of a model's mass on its springs, rad/s."""
    return natural_frequency(model.values("second_order"))


def _rings(evidence: Evidence, refit: Trial) -> bool:
    """Whether mass and damping were fitted, and the ringing lasts from sample to sample."""
    rig = refit.model.values("second_order")
    return set(DYNAMIC) <= set(refit.free) and rings_on(rig, evidence.scales.sample_period)


def _ringing_at(refit: Trial, omega: float) -> Trial:
    """The refit with another mass, and with a damping that lets it ring as long."""
    lighter = (pace(refit.model) / omega) ** 2
    values = {key: lighter * refit.model.value(*key) for key in DYNAMIC}
    return Trial(refit.model.with_values(values), refit.free, refit.initial_hysteresis, math.inf)


def _valleys(left: Array) -> Indices:
    """Where a course is lowest for some way, the ends included."""
    padded = np.concatenate([[np.inf], left, [np.inf]])
    low = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] < padded[2:])
    return np.flatnonzero(low & np.isfinite(left))
