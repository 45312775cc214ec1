"""The model that a diagnosis hands on: with intervals, and with what only a live run needs."""

from __future__ import annotations

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.trial import Trial, problem_of
from microgripper_control.effects.registry import registry
from microgripper_control.identification.confidence import interval
from microgripper_control.identification.determined import variances
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Model, Setting


def identified(evidence: Evidence, trial: Trial) -> Model:
    """The trial's model with 95 % intervals of what was fitted."""
    problem = problem_of(evidence, trial.model, trial.free)
    z = problem.point(trial.model, trial.initial_hysteresis)
    spread = variances(problem, z)
    freedom = sum(int(np.count_nonzero(mask)) for mask in problem.masks) - len(z)
    settings = {}
    for index, key in enumerate(problem.free):
        value, scale = trial.model.value(*key), float(problem.scales[index])
        bounds = interval(value, float(spread[index]) * scale**2, freedom)
        settings[key] = Setting(value, bounds)
    return _as_observed(problem, z, trial.model.with_settings(settings))


def _as_observed(problem: Problem, z: Array, model: Model) -> Model:
    """What the first recording showed of hum and drift, which predictions leave to each recording.

    A live simulation needs their sizes; no prediction changes by them.
    """
    recording, weights = problem.recordings[0], np.array(problem.nuisances(z)[0].weights)
    time = np.asarray(recording.sample_period * np.arange(len(recording)), dtype=np.float64)
    counts = {
        name: len(registry()[name].courses(model.values(name), time)) for name in model.settings
    }
    first = len(weights) - sum(counts.values())  # the zero's weight comes before theirs
    for name, count in counts.items():
        own, first = weights[first : first + count], first + count
        if not count:
            continue
        for key, value in registry()[name].observed(model.values(name), own, time).items():
            inside = registry()[name].parameter(key).nearest(value)
            model = model.with_values({(name, key): inside})
    return model
