"""Identification as in section 5 of the paper: simplex, then trust-region least squares."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.identification.confidence import interval, white_noise
from microgripper_control.identification.determined import (
    DYNAMIC,
    Undetermined,
    add_dynamics,
    drop_undetermined,
    free_parameters,
    spread,
)
from microgripper_control.identification.ends import hold_at_ends
from microgripper_control.identification.levels import rounding_of
from microgripper_control.identification.nuisance import (
    Conditions,
    Nuisance,
    all_in_time,
    predict,
    refuse_divergence,
    response,
)
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.resonance import near_the_resonance
from microgripper_control.identification.search import descend, simplex
from microgripper_control.identification.straight import leave_out_hysteresis
from microgripper_control.plant.model import Key, Model, Setting

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Fit:
    """What identification found; `model` carries the values and their 95 % intervals."""

    model: Model
    recordings: tuple[str, ...]
    nuisances: tuple[Nuisance, ...]
    rmse: tuple[float, ...]  # m, per recording
    relative_rmse: tuple[float, ...]  # of the recording's peak to peak
    white_noise: tuple[float, ...]  # m, per recording: what no model could explain
    gain: Setting  # d k / (k + k_s), m/V
    determined: tuple[Key, ...]
    undetermined: tuple[Undetermined, ...]


def fit(
    model: Model,
    recordings: Sequence[Recording],
    conditions: Conditions | None = None,
    progress: Progress = lambda stage: None,
) -> Fit:
    """Fit the model to recordings of its rig.

    Parameters marked frozen stay; k, k_s and n always do. The mass and the damping join in only if
    the data determine them. Raises MicrogripperError if a recording has no displacement or never
    moves.
    """
    conditions = conditions or Conditions()
    _check(recordings)
    for recording in recordings:
        refuse_divergence(recording, response(model, recording, conditions, 0.0))
    free, undetermined = free_parameters(model)
    if not free:
        raise MicrogripperError(f"{model.name}: every parameter that can be fitted is frozen")
    static = tuple(key for key in free if key not in DYNAMIC)
    problem = Problem(model, all_in_time(model, recordings, conditions), conditions, static)
    progress("simplex")
    z = simplex(problem)
    progress("trust-region reflective least squares")
    z = descend(problem, z)
    dynamic = tuple(key for key in free if key in DYNAMIC)
    if dynamic:
        progress("what the recording can tell about the mechanics")
        z, problem, unseen = _with_dynamics(problem, z, model, dynamic)
        undetermined += unseen
    z, problem, straight = leave_out_hysteresis(problem, z, model)
    z, problem, unseen = drop_undetermined(problem, z, model)
    z, problem, held = hold_at_ends(problem, z)
    return _result(problem, z, undetermined + straight + unseen + held)


def _with_dynamics(
    problem: Problem, z: Array, model: Model, dynamic: tuple[Key, ...]
) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    """Mass and damping fitted where the recordings show them, be it far from the model's."""
    if dynamic == DYNAMIC:
        elsewhere, start = near_the_resonance(problem, z, model)
        if elsewhere is not problem:
            found = add_dynamics(elsewhere, start, dynamic)
            if not found[2]:
                return found
    return add_dynamics(problem, z, dynamic)


def _check(recordings: Sequence[Recording]) -> None:
    if not recordings:
        raise MicrogripperError("no recording given")
    for recording in recordings:
        if np.ptp(recording.voltage) == 0.0 or np.ptp(recording.measured) == 0.0:
            raise MicrogripperError(
                f"{recording.name}: voltage or displacement never changes; record a run that moves"
            )


def _result(problem: Problem, z: Array, undetermined: tuple[Undetermined, ...]) -> Fit:
    found = spread(problem, z)
    model = problem.model_at(z)
    settings = {}
    for index, key in enumerate(problem.free):
        value = model.value(*key)
        scale = float(problem.scales[index])
        variance = float(found.variances[index]) * scale**2
        bounds = interval(value, variance, float(found.freedom[index]))
        settings[key] = Setting(value, bounds)
    model = model.with_settings(settings)
    nuisances = tuple(problem.nuisances(z))
    rmse, relative, white = [], [], []
    for recording, nuisance in zip(problem.recordings, nuisances, strict=True):
        prediction = predict(model, recording, problem.conditions, nuisance)
        used = problem.conditions.answered(recording)
        error = (recording.measured - prediction)[used]
        rmse.append(float(np.sqrt(np.mean(error**2))))
        relative.append(rmse[-1] / float(np.ptp(recording.measured)))
        white.append(_noise(error, recording.measured[used]))
    return Fit(
        model=model,
        recordings=tuple(recording.name for recording in problem.recordings),
        nuisances=nuisances,
        rmse=tuple(rmse),
        relative_rmse=tuple(relative),
        white_noise=tuple(white),
        gain=_gain(model),
        determined=problem.free,
        undetermined=undetermined,
    )


def _noise(error: Array, readings: Array) -> float:
    """The white noise in an error, m rms; `readings`, m, are those that it is the error of.

    Where the voltage rests a coarse sensor shows none, but what rounding leaves is there. Readings
    that a model comes closer to, as those of an exact simulation, were not rounded.
    """
    rmse = float(np.sqrt(np.mean(error**2)))
    return max(white_noise(error), min(rounding_of(readings), rmse))


def _gain(model: Model) -> Setting:
    """d k / (k + k_s), m/V, with the interval that d's carries over."""
    share = static_gain(model.values("second_order"))
    d = model.settings["bouc_wen"]["d"]
    bounds = None if d.interval is None else (d.interval[0] * share, d.interval[1] * share)
    return Setting(d.value * share, bounds)
