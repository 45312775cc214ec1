"""Which first guesses of an effect are worth a fit.

A guess changes the simulated displacement by some course. What of it the base parameters cannot
imitate, held against what the refit left over, tells how much of the gap the effect could take and
how strong it would have to be: a score test, at the cost of one simulation a guess.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.core.parameters import Parameter
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import Base
from microgripper_control.diagnosis.fits.trial import problem_of, with_guess
from microgripper_control.effects.base import Values, no_courses
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Projection
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Model

RESCALED = 4  # guesses whose strength is corrected, and as many that are kept as they are
OTHERS = 2  # kinds beside the best that are fitted from their best guess
RIGHT = 0.05  # of its strength: a guess that is off by less is as strong as it should be
STRONGEST = 30.0  # times, and weakest 1/30: the furthest correction
IDLE = 1e-4  # of the gap's power: a guess that changes less is the last choice,
NOTHING = 1e-3  # and what is courses alone, and takes less away, is none


@dataclass(frozen=True)
class Guess:
    """A base, its model with an effect at first guess, and what a refit would leave, m^2."""

    base: Base
    model: Model
    left: float  # with the effect as it is
    least: float  # with the effect as strong as fits best
    strength: float  # by how much it should be stronger for that
    idle: bool  # whether it changes next to nothing

    @property
    def promised(self) -> float:
        """`left` as an error, m rms."""
        return self._error(self.left)

    @property
    def hoped(self) -> float:
        """`least` as an error, m rms."""
        return self._error(self.least)

    def _error(self, squares: float) -> float:
        return math.sqrt(max(squares, 0.0) / len(self.base.residual))


def guesses(
    evidence: Evidence,
    bases: Sequence[Base],
    effect: str,
    wanted: int,
    found_alone: Sequence[Values] = (),
) -> list[Guess]:
    """First guesses of an effect: `wanted` of the best kind, the best of others and of each base.

    What it was `found_alone` to be, beside no other effect, is one of them in any case.
    """
    starts = [*registry()[effect].starts(evidence.scales), *found_alone]
    problems = {id(base): problem_of(evidence, base.trial.model, base.trial.free) for base in bases}

    def judged(base: Base, model: Model) -> Guess | None:
        return judge(replace(problems[id(base)], model=model), base, effect)

    found = [
        guess
        for base in bases
        for values in starts
        if (guess := judged(base, with_guess(base.trial.model, effect, values)))
    ]
    for guess in sorted(found, key=lambda guess: (guess.idle, guess.least))[:RESCALED]:
        if abs(guess.strength - 1.0) < RIGHT:
            continue
        model = _stronger(guess.model, effect, guess.strength)
        if model is not guess.model and (again := judged(guess.base, model)):
            found.append(again)
    found.sort(key=lambda guess: (guess.idle, guess.left))
    if not found:
        return []
    kinds: dict[tuple[object, ...], list[Guess]] = {}
    for guess in found:
        kinds.setdefault(kind(guess.model, effect), []).append(guess)
    alike, *others = kinds.values()
    firsts = {id(guess.base): guess for guess in reversed(found)}
    as_alone = [guess for guess in found if guess.model.values(effect) in found_alone]
    chosen = [
        *alike[:wanted],
        *(other[0] for other in others[:OTHERS]),
        *firsts.values(),
        *as_alone,
    ]
    return [guess for guess in found if any(guess is one for one in chosen)]


def kind(model: Model, effect: str) -> tuple[object, ...]:
    """What a fit leaves as it was: a law may have parts of which a start takes one or the other."""
    link, values = registry()[effect], model.values(effect)
    kept = (values[parameter.name] for parameter in link.parameters if not parameter.fitted)
    return (*kept, *sorted(link.idle(values)))


def judge(problem: Problem, base: Base, effect: str) -> Guess | None:
    """What a refit could leave with a guess, which is the model of the problem.

    None where that is no start or not to be simulated.
    """
    model = problem.model
    z = problem.point(model, base.trial.initial_hysteresis)
    try:
        residual = problem.residuals(z)
    except (ValueError, FloatingPointError, np.linalg.LinAlgError):
        return None
    if residual.shape != base.residual.shape or not np.all(np.isfinite(residual)):
        return None
    link = registry()[effect]
    own = link.courses is not no_courses
    off, without = Projection(base.basis), base.rest
    if own:
        off = Projection(np.linalg.qr(problem.projected(z, base.basis))[0])
        without = off(problem.projected(z, base.residual[:, None])[:, 0])
    change = without - off(residual)
    power, size, match = (
        float(a @ b) for a, b in ((without, without), (change, change), (change, without))
    )
    left = power - 2.0 * match + size
    if link.random and left > (1.0 - NOTHING) * float(base.rest @ base.rest):
        return None
    if own and size < IDLE * power:  # courses alone are as strong as fits best already
        return Guess(base, model, left, least=left, strength=1.0, idle=False)
    strength = match / size if size > 0.0 else 0.0
    if strength < 0.0 and not _may_turn(model, effect):
        strength = 0.0
    least = power - strength * match
    return Guess(base, model, left, least, strength, idle=size < IDLE * power)


def _strengths(model: Model, effect: str) -> list[Parameter]:
    """The parameters at work that make an effect as much stronger as they are larger."""
    values = model.values(effect)
    return [
        parameter
        for parameter in registry()[effect].parameters
        if parameter.fitted and parameter.vanishing == 0.0 and values[parameter.name] != 0.0
    ]


def _may_turn(model: Model, effect: str) -> bool:
    """Whether an effect may act the other way."""
    return any(parameter.low < 0.0 for parameter in _strengths(model, effect))


def _stronger(model: Model, effect: str, strength: float) -> Model:
    """The model with the effect made stronger, as it is where its strength is no factor."""
    link, values = registry()[effect], model.values(effect)
    changed: dict[str, float] = {}
    for parameter in _strengths(model, effect):
        if strength < 0.0 and parameter.low >= 0.0:
            factor = 1.0 / STRONGEST
        else:
            size = min(STRONGEST, max(1.0 / STRONGEST, abs(strength)))
            factor = size if strength >= 0.0 else -size
        changed[parameter.name] = factor * values[parameter.name]
        changed.update(link.rescaled(values, factor))
    return with_guess(model, effect, {**values, **changed}) if changed else model
