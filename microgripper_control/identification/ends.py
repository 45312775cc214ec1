"""What a fit carries to the end of its range, or leaves without any end, is no identified value."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.identification.determined import Undetermined, spread
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Key

ON_BOUND = 1e-6  # of a parameter's nominal value: a descent stays that far inside


def hold_at_ends(problem: Problem, z: Array) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    """Hold where it is what ends on a bound, then what the recordings leave open altogether.

    The nominal value was found to fit worse, so nothing returns there.
    """
    z, problem, bound = _held(problem, z, _on_bounds(problem, z))
    z, problem, endless = _held(problem, z, _open(problem, z))
    return z, problem, bound + endless


def _on_bounds(problem: Problem, z: Array) -> dict[Key, str]:
    model, reasons = problem.model_at(z), {}
    for key in problem.free:
        declared, value = registry()[key[0]].parameter(key[1]), model.value(*key)
        near = ON_BOUND * (abs(declared.nominal) or declared.high - declared.low)
        if value - declared.low < near:
            reasons[key] = f"it ends on its lower bound, {declared.low:g}"
        elif declared.high - value < near:
            reasons[key] = f"it ends on its upper bound, {declared.high:g}"
    return reasons


def _open(problem: Problem, z: Array) -> dict[Key, str]:
    variances = spread(problem, z).variances
    endless = [key for key, v in zip(problem.free, variances, strict=True) if not np.isfinite(v)]
    return dict.fromkeys(endless, "the recording leaves it open altogether")


def _held(
    problem: Problem, z: Array, reasons: dict[Key, str]
) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    """The problem without some of its free parameters, which stay where they are."""
    if not reasons:
        return z, problem, ()
    model = problem.model_at(z)
    rest = tuple(key for key in problem.free if key not in reasons)
    smaller = replace(problem, model=model, free=rest)
    named = tuple(Undetermined(key, reason) for key, reason in reasons.items())
    return smaller.point(model, problem.initial_hysteresis(z)), smaller, named
