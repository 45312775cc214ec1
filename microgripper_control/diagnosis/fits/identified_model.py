"""The model that a diagnosis hands on: with intervals, and with what only a live run needs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial, problem_of
from microgripper_control.effects.base import Values
from microgripper_control.effects.registry import registry
from microgripper_control.identification.confidence import autocorrelation_time, interval
from microgripper_control.identification.determined import spread
from microgripper_control.identification.nuisance import own_courses
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Key, Model, Setting

LIKELY = 3.84  # chi squared of one parameter at 95 %
HALVINGS = 12  # of a sample period: how closely the end of a range is told


def identified(evidence: Evidence, trial: Trial) -> Model:
    """The trial's model with 95 % intervals of what was fitted.

    What may be anything at all, for what the recordings tell, is held while the others' are taken:
    their derivatives would trade with its far beyond its range.
    """
    problem = problem_of(evidence, trial.model, trial.free)
    z = problem.point(trial.model, trial.initial_hysteresis)
    found = told = _intervals(problem, z)
    while known := tuple(key for key, (low, high) in told.items() if math.isfinite(high - low)):
        if len(known) == len(told):
            break
        fewer = replace(problem, free=known)
        told = _intervals(fewer, fewer.point(trial.model, trial.initial_hysteresis))
        found = found | told
    settings = {key: Setting(trial.model.value(*key), ends) for key, ends in found.items()}
    return _as_observed(problem, z, trial.model.with_settings(settings))


def _intervals(problem: Problem, z: Array) -> dict[Key, tuple[float, float]]:
    """Of each free parameter; infinite where it may be anything."""
    scatter, model = spread(problem, z), problem.model_at(z)
    found = {}
    for index, (link, name) in enumerate(problem.free):
        scale = float(problem.scales[index])
        variance = float(scatter.variances[index]) * scale**2
        bounds = interval(model.value(link, name), variance, float(scatter.freedom[index]))
        if problem.by_sample(index):
            bounds = _without_a_trace(problem, z, index)
        found[link, name] = allowed(bounds, registry()[link].parameter(name))
    return found


def allowed(bounds: tuple[float, float], parameter: Parameter) -> tuple[float, float]:
    """An interval as far as the parameter may go; infinite if that tells nothing of it."""
    low, high = bounds
    if low <= parameter.low and high >= parameter.high:
        return -math.inf, math.inf
    return parameter.nearest(low), parameter.nearest(high)


def _without_a_trace(problem: Problem, z: Array, index: int) -> tuple[float, float]:
    """Between which delays, s, the recordings show no difference.

    A plant that settles within a sample answers to a held voltage alike wherever in the sample it
    steps, and another sample late quite otherwise: a derivative tells nothing of that.
    """
    residuals, scale = problem.residuals(z), float(problem.scales[index])
    least = float(residuals @ residuals)
    most = least * (1.0 + LIKELY * autocorrelation_time(residuals) / len(residuals))

    def likely(delay: float) -> bool:
        other = z.copy()
        other[index] = delay / scale
        left = problem.residuals(other)
        return float(left @ left) <= most

    value, period = float(z[index]) * scale, problem.longest_period
    return _end(likely, value, max(0.0, value - period)), _end(likely, value, value + period)


def _end(likely: Callable[[float], bool], inside: float, beyond: float) -> float:
    """Where on the way from a likely value to another it is so no longer."""
    if likely(beyond):
        return beyond
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + beyond)
        inside, beyond = (middle, beyond) if likely(middle) else (inside, middle)
    return inside


def _as_observed(problem: Problem, z: Array, model: Model) -> Model:
    """What recordings showed most of hum and drift, which predictions leave to each of them.

    A live simulation needs their sizes; no prediction changes by them.
    """
    most: dict[str, tuple[float, Values]] = {}  # of each link, the largest course and its values
    for recording, nuisance in zip(problem.recordings, problem.nuisances(z), strict=True):
        for name, (weights, courses) in own_courses(model, recording, nuisance).items():
            size = float(np.std(weights @ courses))
            if size >= most.get(name, (0.0,))[0]:
                values = model.values(name)
                seen = registry()[name].observed(values, weights, recording.elapsed)
                most[name] = size, seen
    for name, (_, seen) in most.items():
        for key, value in seen.items():
            inside = registry()[name].parameter(key).nearest(value)
            model = model.with_values({(name, key): inside})
    return model
