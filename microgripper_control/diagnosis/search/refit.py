"""The nominal model as it is, and with its own parameters fitted to the recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import FINE, fit_on, refine
from microgripper_control.diagnosis.fits.trial import (
    Trial,
    fitted_keys,
    judged,
    problem_of,
    starting_hysteresis,
    unfitted,
)
from microgripper_control.diagnosis.search.ringing import other_frequencies
from microgripper_control.identification.determined import DYNAMIC, shown_dynamics
from microgripper_control.identification.nuisance import refuse_divergence, response
from microgripper_control.identification.start import GRID_KEYS, better_start
from microgripper_control.plant.model import Key, Model

FAR_OFF = 0.01  # of the stroke: a refit that leaves more may have gone astray
OTHER_STARTS = (-0.4, 0.4)  # of the largest h
HARDLY = 1e-6  # of the trust in the nominal model: a fit goes where the recordings send it


def nominal_trial(evidence: Evidence, model: Model) -> Trial:
    """The model as it was given, judged; its own effects belong to it."""
    return _at(evidence, model, _static_keys(model), starting_hysteresis(evidence, model))


def refits(evidence: Evidence, nominal: Trial) -> list[Trial]:
    """`refit_trial`, and its like at other natural frequencies of a rig that rings; best first."""
    found = refit_trial(evidence, nominal)
    return sorted((found, *other_frequencies(evidence, found)), key=lambda trial: trial.both)


def refit_trial(evidence: Evidence, nominal: Trial) -> Trial:
    """Its own parameters fitted: from where they are and, if that ends badly, from a coarse grid.

    What the nominal model leaves makes its own parameters weigh much at first, and the h that it
    would have before a recording may lead astray: so they are also fitted without that weight and
    from other h, then with it, and what foretells the recordings best is taken. Mass and damping
    join in where the recordings show them.
    """
    problem = problem_of(evidence, nominal.model, nominal.free)
    others = [
        replace(nominal, initial_hysteresis=tuple(share * problem.hysteresis_scales))
        for share in OTHER_STARTS
        if len(problem.hysteresis_scales)
    ]
    free = [fit_on(evidence, one, FINE, 40, trust=HARDLY) for one in (nominal, *others)]
    found = min((refine(evidence, one) for one in (nominal, *free)), key=lambda trial: trial.both)
    if found.fitted_rmse > FAR_OFF * evidence.scales.stroke and set(GRID_KEYS) <= set(found.free):
        problem = problem_of(evidence, nominal.model, nominal.free)
        model, initial = better_start(problem, nominal.initial_hysteresis)
        other = refine(evidence, _at(evidence, model, nominal.free, tuple(initial)))
        found = min(found, other, key=lambda trial: trial.fitted_rmse)
    problem = problem_of(evidence, found.model, found.free)
    z = problem.point(found.model, found.initial_hysteresis)
    dynamic = tuple(
        key for key in fitted_keys(nominal.model, list(nominal.model.settings)) if key in DYNAMIC
    )
    if not dynamic:
        return found
    shown = shown_dynamics(problem, z, dynamic)
    if not shown:
        return found
    return refine(evidence, replace(found, free=(*found.free, *shown), errors=()))


def _static_keys(model: Model) -> tuple[Key, ...]:
    keys = fitted_keys(model, list(model.settings))
    return tuple(key for key in keys if key not in DYNAMIC)


def _at(
    evidence: Evidence, model: Model, free: tuple[Key, ...], initial: tuple[float, ...]
) -> Trial:
    trial = unfitted(evidence, Trial(model, free, initial, np.inf))
    if not np.isfinite(trial.fitted_rmse):
        for recording in evidence.fitted:
            refuse_divergence(recording, response(model, recording, evidence.conditions, 0.0))
        raise MicrogripperError("the nominal model does not answer to the recordings")
    return judged(evidence, trial)
