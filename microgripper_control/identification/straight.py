"""A rig that shows no hysteresis: alpha is about zero then, and beta and gamma shape nothing.

Taken to their nominal values one at a time, an alpha that is not there would come back, and beta or
gamma run away to cancel it.
"""

from __future__ import annotations

from dataclasses import replace

from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.identification.confidence import interval
from microgripper_control.identification.determined import (
    Undetermined,
    open_parameters,
    rise,
    spread,
)
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.search import descend
from microgripper_control.identification.start import ALPHA, BETA, GAMMA
from microgripper_control.plant.model import Model, Setting

SHAPE = (ALPHA, BETA, GAMMA)
CHANCE = 0.01  # that noise alone asks for a hysteresis


def leave_out_hysteresis(
    problem: Problem, z: Array, nominal: Model
) -> tuple[Array, Problem, tuple[Undetermined, ...]]:
    """Hold alpha at zero where the recordings leave its shape open and fit as well without it."""
    opened = {key for _, key in open_parameters(problem, z)}
    if not set(SHAPE) <= set(problem.free) or not opened & set(SHAPE):
        return z, problem, ()
    values = {key: nominal.value(*key) for key in (BETA, GAMMA)} | {ALPHA: 0.0}
    model = problem.model_at(z).with_values(values)
    rest = tuple(key for key in problem.free if key not in SHAPE)
    smaller = replace(problem, model=model, free=rest)
    point = descend(smaller, smaller.point(model, ()))
    if rise(problem, z, smaller, point) > _significant(len(z) - len(point)):
        return z, problem, ()
    most = _most(smaller, point)
    model = smaller.model.with_settings({ALPHA: Setting(0.0, (0.0, most))})
    return point, replace(smaller, model=model), _reasons(most)


def _significant(count: int) -> float:
    """The rise of chi-squared, of so many values that are left out, that is no chance."""
    from scipy.special import chdtri  # takes 0.03 s to import: not for a node

    return float(chdtri(count, CHANCE))


def _most(smaller: Problem, point: Array) -> float:
    """The largest alpha that the recordings allow, with beta and gamma as they are given."""
    model = smaller.model_at(point)
    wider = replace(smaller, model=model, free=(*smaller.free, ALPHA))
    z = descend(wider, wider.point(model, ()))
    found, scale = spread(wider, z), float(wider.scales[-1])
    variance, freedom = float(found.variances[-1]) * scale**2, float(found.freedom[-1])
    high = interval(wider.model_at(z).value(*ALPHA), variance, freedom)[1]
    return registry()[ALPHA[0]].parameter(ALPHA[1]).nearest(high)


def _reasons(most: float) -> tuple[Undetermined, ...]:
    shown = f"the recording shows no hysteresis: 0, or {most:.2g} at most"
    shape = "no hysteresis shows its shape"
    return Undetermined(ALPHA, shown), Undetermined(BETA, shape), Undetermined(GAMMA, shape)
