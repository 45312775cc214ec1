"""Identification as in section 5 of the paper: simplex, then trust-region least squares."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, minimize

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.effects.registry import registry
from microgripper_control.identification.confidence import (
    autocorrelation_time,
    covariance,
    interval,
    white_noise,
)
from microgripper_control.identification.nuisance import (
    Conditions,
    Nuisance,
    fit_nuisance,
    predict,
)
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.start import GRID_KEYS, better_start
from microgripper_control.plant.model import Key, Model, Setting

SIMPLEX_EVALUATIONS = 200
LARGEST_RELATIVE_ERROR = 0.3  # a standard error above this share of a value determines nothing
SIGNIFICANT_RISE = 6.63  # of chi-squared, one degree of freedom, 99 %
DYNAMIC: tuple[Key, ...] = (("second_order", "m"), ("second_order", "b"))

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Undetermined:
    """A parameter that stays at its nominal value, and why."""

    key: Key
    reason: str


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
    free, undetermined = _free_parameters(model)
    static = tuple(key for key in free if key not in DYNAMIC)
    progress("simplex")
    z, problem = _simplex(Problem(model, recordings, conditions, static))
    progress("trust-region reflective least squares")
    z = _least_squares(problem, z)
    dynamic = tuple(key for key in free if key in DYNAMIC)
    if dynamic:
        progress("what the recording can tell about the mechanics")
        z, problem, unseen = _add_dynamics(problem, z, dynamic)
        undetermined += unseen
    z, problem, unseen = _drop_undetermined(problem, z, model)
    return _result(problem, z, undetermined + unseen)


def _check(recordings: Sequence[Recording]) -> None:
    if not recordings:
        raise MicrogripperError("no recording given")
    for recording in recordings:
        if np.ptp(recording.voltage) == 0.0 or np.ptp(recording.measured) == 0.0:
            raise MicrogripperError(
                f"{recording.name}: voltage or displacement never changes; record a run that moves"
            )


def _free_parameters(model: Model) -> tuple[tuple[Key, ...], tuple[Undetermined, ...]]:
    free, undetermined = [], []
    for link, settings in model.settings.items():
        for name, setting in settings.items():
            declared = registry()[link].parameter(name)
            if setting.frozen:
                undetermined.append(Undetermined((link, name), "frozen in the model"))
            elif declared.fitted:
                free.append((link, name))
    for name in ("k", "k_s"):
        reason = "k and k_s show only together, as the gain d k/(k + k_s)"
        undetermined.append(Undetermined(("second_order", name), reason))
    return tuple(free), tuple(undetermined)


def _simplex(problem: Problem) -> tuple[Array, Problem]:
    """Nelder-Mead on the parameters alone, each recording's initial h as the start has it."""
    model = problem.model
    initial = [
        fit_nuisance(model, recording, problem.conditions).initial_hysteresis
        for recording in problem.recordings
    ]
    if set(GRID_KEYS) <= set(problem.free) and model.value("bouc_wen", "n") == 1.0:
        model, initial = better_start(problem, initial)
    start = problem.point(model, initial)
    count = len(problem.free)
    low, high = problem.bounds

    def squares(part: Array) -> float:
        residuals = problem.residuals(np.append(part, start[count:]))
        return float(residuals @ residuals) if np.all(np.isfinite(residuals)) else np.inf

    best = minimize(
        squares,
        start[:count],
        method="Nelder-Mead",
        bounds=list(zip(low[:count], high[:count], strict=True)),
        options={"maxfev": SIMPLEX_EVALUATIONS, "xatol": 1e-4, "fatol": 0.0},
    )
    return np.append(best.x, start[count:]), problem


def _least_squares(problem: Problem, z: Array) -> Array:
    low, high = problem.bounds
    inside = np.clip(z, low, high)
    best = least_squares(
        problem.residuals,
        inside,
        jac=problem.jacobian,
        bounds=(low, high),
        method="trf",
        x_scale="jac",
        xtol=1e-10,
        ftol=1e-12,
        gtol=1e-15,
    )
    return np.asarray(best.x)


def _variances(problem: Problem, z: Array) -> Array:
    """Variances of z, shape (len(z),)."""
    residuals = np.split(problem.residuals(z), np.cumsum([len(r) for r in problem.recordings])[:-1])
    return np.diag(covariance(problem.jacobian(z), residuals, len(problem.recordings)))


def _errors(problem: Problem, z: Array) -> Array:
    """Standard error of each free parameter relative to its size."""
    return np.sqrt(_variances(problem, z)[: len(problem.free)])


def _extended(problem: Problem, z: Array, extra: Sequence[Key]) -> tuple[Problem, Array]:
    """The problem with more free parameters, and the same point in it."""
    model = problem.model_at(z)
    wider = replace(problem, model=model, free=(*problem.free, *extra))
    return wider, wider.point(model, problem.initial_hysteresis(z))


def _add_dynamics(
    problem: Problem, z: Array, dynamic: tuple[Key, ...]
) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    wider, point = _extended(problem, z, dynamic)
    errors = _errors(wider, point)[-len(dynamic) :]
    seen = [key for key, e in zip(dynamic, errors, strict=True) if e < LARGEST_RELATIVE_ERROR]
    unseen = tuple(
        Undetermined(key, "the recording is too slow to show the resonance")
        for key in dynamic
        if key not in seen
    )
    if not seen:
        return z, problem, unseen
    wider, point = _extended(problem, z, seen)
    return _least_squares(wider, point), wider, unseen


def _drop_undetermined(
    problem: Problem, z: Array, nominal: Model
) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    """Return to its nominal value, one at a time, what the data neither tell nor contradict.

    A wide interval alone is no reason: the parameter must also fit as well at its nominal value.
    """
    dropped: list[Undetermined] = []
    needed: set[Key] = set()
    while len(problem.free) > 1:
        errors = _errors(problem, z)
        open_ones = [
            (float(error), key)
            for error, key in zip(errors, problem.free, strict=True)
            if error > LARGEST_RELATIVE_ERROR and key not in needed
        ]
        if not open_ones:
            break
        error, key = max(open_ones)
        model = problem.model_at(z).with_values({key: nominal.value(*key)})
        rest = tuple(other for other in problem.free if other != key)
        smaller = replace(problem, model=model, free=rest)
        point = smaller.point(model, problem.initial_hysteresis(z))
        point = _least_squares(smaller, point)
        if _rise(problem, z, smaller, point) > SIGNIFICANT_RISE:
            needed.add(key)
            continue
        reason = f"the recording leaves it open to {100.0 * min(error, 1e4):.0f} %"
        dropped.append(Undetermined(key, reason))
        problem, z = smaller, point
    return z, problem, tuple(dropped)


def _rise(problem: Problem, z: Array, smaller: Problem, point: Array) -> float:
    """How much worse the smaller problem fits: chi-squared with one degree of freedom."""
    residuals, worse = problem.residuals(z), smaller.residuals(point)
    squares = float(residuals @ residuals)
    independent = len(residuals) / autocorrelation_time(residuals)
    return independent * (float(worse @ worse) - squares) / squares


def _result(problem: Problem, z: Array, undetermined: tuple[Undetermined, ...]) -> Fit:
    variances = _variances(problem, z)
    samples = sum(len(recording) for recording in problem.recordings)
    freedom = samples - len(z) - problem.eliminated
    model = problem.model_at(z)
    settings = {}
    for index, key in enumerate(problem.free):
        value = model.value(*key)
        scale = float(problem.scales[index])
        bounds = interval(value, float(variances[index]) * scale**2, freedom)
        settings[key] = Setting(value, bounds)
    model = model.with_settings(settings)
    nuisances = tuple(problem.nuisances(z))
    rmse, relative, white = [], [], []
    for recording, nuisance in zip(problem.recordings, nuisances, strict=True):
        prediction = predict(model, recording, problem.conditions, nuisance)
        error = (recording.measured - prediction)[problem.conditions.unanswered :]
        rmse.append(float(np.sqrt(np.mean(error**2))))
        relative.append(rmse[-1] / float(np.ptp(recording.measured)))
        white.append(white_noise(error))
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


def _gain(model: Model) -> Setting:
    """d k / (k + k_s), m/V, with the interval that d's carries over."""
    share = static_gain(model.values("second_order"))
    d = model.settings["bouc_wen"]["d"]
    bounds = None if d.interval is None else (d.interval[0] * share, d.interval[1] * share)
    return Setting(d.value * share, bounds)
