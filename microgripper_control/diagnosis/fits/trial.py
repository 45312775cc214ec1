"""An explanation with its fitted values and what it leaves: the residuals that judge it.

Every explanation, the nominal model's too, has its base parameters refitted with it: otherwise a
mistuned alpha would be blamed on whatever effect resembles it. How they are fitted: `fitting`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.data.noise import innovation, quietest
from microgripper_control.effects.base import Values
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import fit_nuisance
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Key, Model


@dataclass(frozen=True)
class Trial:
    """A fitted explanation and, once it is judged, what it leaves, m, on the samples that judge."""

    model: Model
    free: tuple[Key, ...]
    initial_hysteresis: tuple[float, ...]  # m, of each fitted recording
    fitted_rmse: float  # m, on the fitted samples
    errors: tuple[Array, ...] = ()  # m, of each judged recording; none before it is judged

    @property
    def effects(self) -> tuple[str, ...]:
        """The links it has beyond the paper's plant."""
        return self.model.effects

    @cached_property
    def rmse(self) -> float:
        """Root mean square error on the judging samples, m."""
        return rms(self.errors)

    @cached_property
    def noise_floor(self) -> float:
        """The innovation of its errors, m, which cannot be more than they are."""
        return min(innovation(self.errors), self.rmse)

    @cached_property
    def quietest(self) -> float:
        """The innovation by the median, m, on the quietest recording that judges it."""
        return quietest(self.errors)

    @property
    def both(self) -> float:
        """Root mean square error, m, fitted samples given as much weight as judging ones."""
        return evenly(self.rmse, self.fitted_rmse)


def evenly(judged: float, fitted: float) -> float:
    """Two errors as one, m rms, with as much weight for each."""
    return math.hypot(judged, fitted) / math.sqrt(2.0)


def added(evidence: Evidence, trial: Trial) -> frozenset[str]:
    """The effects of a trial that the nominal model has not."""
    return frozenset(trial.effects).difference(evidence.nominal.effects)


def with_guess(model: Model, effect: str, values: Values) -> Model:
    """The model with an effect, as far towards a guess as its parameters' ranges allow."""
    link = registry()[effect]
    inside = {name: link.parameter(name).nearest(value) for name, value in values.items()}
    return model.with_link(effect, **inside)


def fitted_keys(model: Model, links: Sequence[str]) -> tuple[Key, ...]:
    """What a trial fits of some links: all that can be fitted, is not frozen and not idle."""
    return tuple(
        (link, name)
        for link in links
        for name, setting in model.settings[link].items()
        if registry()[link].parameter(name).fitted
        and not setting.frozen
        and name not in registry()[link].idle(model.values(link))
    )


def problem_of(evidence: Evidence, model: Model, free: Sequence[Key]) -> Problem:
    """The least-squares problem of a model on the fitted samples, within what is plausible."""
    limits = limits_of(evidence, model.settings)
    return Problem(model, evidence.fitted, evidence.conditions, tuple(free), evidence.used, limits)


def limits_of(evidence: Evidence, links: Iterable[str]) -> dict[Key, tuple[float, float]]:
    """The ranges of some links' parameters that are narrower than declared, on the rig at hand.

    What the nominal model has is plausible, and nothing beyond a parameter's own range is.
    """
    limits = {}
    for link in links:
        own = evidence.nominal.settings.get(link, {})
        for name, bounds in registry()[link].plausible(evidence.scales).items():
            declared = registry()[link].parameter(name)
            known = [own[name].value] if name in own else []
            limits[link, name] = (
                declared.nearest(min(*bounds, *known)),
                declared.nearest(max(*bounds, *known)),
            )
    return limits


def starting_hysteresis(evidence: Evidence, model: Model) -> tuple[float, ...]:
    """h, m, that each fitted recording starts with according to a model."""
    return tuple(
        fit_nuisance(model, recording, evidence.conditions, used).initial_hysteresis
        for recording, used in zip(evidence.fitted, evidence.used, strict=True)
    )


def trial_at(problem: Problem, z: Array, squares: float) -> Trial:
    """The trial at a point of a problem with its sum of squares, m^2; not judged."""
    return Trial(
        model=problem.model_at(z),
        free=problem.free,
        initial_hysteresis=tuple(problem.initial_hysteresis(z)),
        fitted_rmse=float(np.sqrt(squares / problem.samples)),
    )


def without(trial: Trial, name: str) -> Trial:
    """An explanation with one effect taken out; not fitted, nor judged."""
    free = tuple(key for key in trial.free if key[0] != name)
    return Trial(trial.model.without([name]), free, trial.initial_hysteresis, math.inf)


def unfitted(evidence: Evidence, trial: Trial) -> Trial:
    """The same values on other evidence; not judged yet."""
    problem = problem_of(evidence, trial.model, trial.free)
    z = problem.point(trial.model, trial.initial_hysteresis)
    residuals = problem.residuals(z)
    return trial_at(problem, z, float(residuals @ residuals))


def moved(evidence: Evidence, trial: Trial) -> Trial:
    """The same model on other recordings, which start with an h of their own; not judged yet."""
    return replace(trial, initial_hysteresis=starting_hysteresis(evidence, trial.model))


@np.errstate(all="ignore")  # what was fitted elsewhere may overflow
def judged(evidence: Evidence, trial: Trial) -> Trial:
    """The trial with what it leaves on the judging samples."""
    return replace(trial, errors=tuple(evidence.errors(trial.model)))


def judged_once(evidence: Evidence, trial: Trial) -> Trial:
    """The trial judged, if it is not already."""
    return trial if trial.errors else judged(evidence, trial)
