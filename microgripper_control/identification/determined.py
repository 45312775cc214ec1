"""Which parameters the recordings determine.

What they do not stays at its nominal value and is named, instead of a number being invented.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.identification.confidence import (
    Spread,
    autocorrelation_time,
    spread_of,
)
from microgripper_control.identification.elimination import Split
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.search import descend
from microgripper_control.plant.model import Key, Model

LARGEST_RELATIVE_ERROR = 0.3  # a standard error above this share of a value determines nothing
SIGNIFICANT_RISE = 6.63  # of chi-squared, one degree of freedom, 99 %
DYNAMIC: tuple[Key, ...] = (("second_order", "m"), ("second_order", "b"))
STIFFNESSES: tuple[Key, ...] = (("second_order", "k"), ("second_order", "k_s"))


@dataclass(frozen=True)
class Undetermined:
    """A parameter that was not identified, and why: most stay at their nominal values."""

    key: Key
    reason: str


def free_parameters(model: Model) -> tuple[tuple[Key, ...], tuple[Undetermined, ...]]:
    """What a fit may change, and what it may not, with the reason."""
    free, undetermined = [], []
    for link, settings in model.settings.items():
        for name, setting in settings.items():
            declared = registry()[link].parameter(name)
            if setting.frozen:
                undetermined.append(Undetermined((link, name), "frozen in the model"))
            elif declared.fitted:
                free.append((link, name))
    reason = "k and k_s show only together, as the gain d k/(k + k_s)"
    named = {entry.key for entry in undetermined}
    undetermined += [Undetermined(key, reason) for key in STIFFNESSES if key not in named]
    return tuple(free), tuple(undetermined)


def spread(problem: Problem, z: Array) -> Spread:
    """How far the free parameters scatter in z, in the order of `problem.free`."""
    return problem.spreads.at(z, lambda: _spread(problem, z))


def _spread(problem: Problem, z: Array) -> Spread:
    split = Split.by_recording(problem, z, problem.columns(z, range(len(problem.free))))
    own = len(split.sizes) > 0
    offsets = [weights + own for weights in problem.eliminated]
    return spread_of(split.rest, problem.split_residuals(z), offsets)


def _errors(problem: Problem, z: Array) -> Array:
    """Standard error of each free parameter relative to its size."""
    return np.sqrt(spread(problem, z).variances)


def _extended(problem: Problem, z: Array, extra: Sequence[Key]) -> tuple[Problem, Array]:
    """The problem with more free parameters, and the same point in it."""
    model = problem.model_at(z)
    wider = replace(problem, model=model, free=(*problem.free, *extra))
    return wider, wider.point(model, problem.initial_hysteresis(z))


def add_dynamics(
    problem: Problem, z: Array, dynamic: tuple[Key, ...]
) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    """Fit mass and damping, too, where the recordings show the resonance."""
    seen = shown_dynamics(problem, z, dynamic)
    unseen = tuple(
        Undetermined(key, "the recording is too slow to show the resonance")
        for key in dynamic
        if key not in seen
    )
    if not seen:
        return z, problem, unseen
    wider, point = _extended(problem, z, seen)
    return descend(wider, point), wider, unseen


def shown_dynamics(problem: Problem, z: Array, dynamic: tuple[Key, ...]) -> tuple[Key, ...]:
    """Those of mass and damping that the recordings would tell, beside what is fitted already."""
    errors = _errors(*_extended(problem, z, dynamic))[-len(dynamic) :]
    return tuple(key for key, e in zip(dynamic, errors, strict=True) if e < LARGEST_RELATIVE_ERROR)


def drop_undetermined(
    problem: Problem, z: Array, nominal: Model
) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    """Return to its nominal value, one at a time, what the data neither tell nor contradict.

    A wide interval alone is no reason: the parameter must also fit as well at its nominal value.
    """
    dropped: list[Undetermined] = []
    needed: set[Key] = set()
    while len(problem.free) > 1:
        open_ones = [one for one in open_parameters(problem, z) if one[1] not in needed]
        if not open_ones:
            break
        error, key = max(open_ones)
        model = problem.model_at(z).with_values({key: nominal.value(*key)})
        rest = tuple(other for other in problem.free if other != key)
        smaller = replace(problem, model=model, free=rest)
        point = smaller.point(model, problem.initial_hysteresis(z))
        # A nominal value beside values that are the rig's own may be no model at all.
        if not math.isfinite(_squares(smaller, point)):
            needed.add(key)
            continue
        point = descend(smaller, point)
        if rise(problem, z, smaller, point) > SIGNIFICANT_RISE:
            needed.add(key)
            continue
        reason = f"the recording leaves it open to {100.0 * min(error, 1e4):.0f} %"
        dropped.append(Undetermined(key, reason))
        problem, z = smaller, point
    return z, problem, tuple(dropped)


def open_parameters(problem: Problem, z: Array) -> list[tuple[float, Key]]:
    """The free parameters whose standard error, relative to their size, determines nothing."""
    errors = zip(map(float, _errors(problem, z)), problem.free, strict=True)
    return [(error, key) for error, key in errors if error > LARGEST_RELATIVE_ERROR]


def rise(problem: Problem, z: Array, smaller: Problem, point: Array) -> float:
    """How much worse the smaller problem fits: chi-squared of as many as it has fewer values."""
    residuals, squares = problem.residuals(z), _squares(problem, z)
    independent = len(residuals) / autocorrelation_time(residuals)
    return independent * (_squares(smaller, point) - squares) / squares


@np.errstate(all="ignore")
def _squares(problem: Problem, z: Array) -> float:
    """Sum of the squared residuals, m^2; not finite where the model diverges."""
    residuals = problem.residuals(z)
    return float(residuals @ residuals)
