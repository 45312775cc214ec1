"""One effect added to an explanation: the best fit of it, and why there is none.

Nothing that goes wrong with one effect stops the others: what cannot be fitted is told, not raised.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from microgripper_control.core.quantities import quantity
from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.data.grid import refuted
from microgripper_control.diagnosis.fits.fitting import Base
from microgripper_control.diagnosis.fits.trial import Trial, evenly, judged, with_guess
from microgripper_control.diagnosis.search.beginning import begun_from_nothing
from microgripper_control.diagnosis.search.from_a_part import by_way_of_a_part
from microgripper_control.diagnosis.search.from_guesses import (
    EXPLAINS_NOTHING,
    best_first,
    first_guesses,
    fits_from,
)
from microgripper_control.diagnosis.search.screening import guesses
from microgripper_control.diagnosis.search.scrutiny import Scrutiny
from microgripper_control.diagnosis.search.stretches import GLANCE, on_a_part
from microgripper_control.effects.base import Values
from microgripper_control.effects.registry import registry

FOLLOWS = 0.5  # of what the base leaves: a fit that leaves less has found something to follow


def attempt(
    evidence: Evidence, bases: Sequence[Base], name: str, scrutiny: Scrutiny
) -> tuple[str, Trial | None, str]:
    """Add one effect to the bases: its name, the best fit, and why there is none."""
    try:
        with np.errstate(all="ignore"):  # a hopeless guess may overflow: it is then no start
            found, why = _attempt(evidence, bases, name, scrutiny)
            if found is not None and math.isinf(scrutiny.hopeless):
                found = begun_from_nothing(evidence, found, name)
            return name, found, why
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        return name, None, f"could not be fitted: {error}"


def _attempt(
    evidence: Evidence, bases: Sequence[Base], name: str, scrutiny: Scrutiny
) -> tuple[Trial | None, str]:
    link = registry()[name]
    if not link.starts(evidence.scales):
        return None, "nothing in the recordings to start from"
    if link.read_off:
        return _read_off(evidence, bases[0].trial, name)
    part, anchors = on_a_part(evidence, bases, name, scrutiny.samples)
    shown = rms([anchors[0].residual])
    scrutiny = scrutiny.where_shown(bases[0].trial.fitted_rmse, shown)
    if part is evidence:
        return _at_once(evidence, bases, name, scrutiny)
    return by_way_of_a_part(evidence, bases[0], part, anchors, name, scrutiny)


def _read_off(evidence: Evidence, trial: Trial, name: str) -> tuple[Trial | None, str]:
    """An effect whose values are read off the recordings: a grid, unless readings refute it."""
    grid = evidence.grid
    if refuted(grid, trial.fitted_rmse, [recording.measured for recording in evidence.fitted]):
        steps = quantity(grid.step, "m")
        return None, f"readings on steps of {steps} could not follow so closely"
    return behind(evidence, trial, name), ""


def _at_once(
    evidence: Evidence, bases: Sequence[Base], name: str, scrutiny: Scrutiny
) -> tuple[Trial | None, str]:
    """The best fit of an effect that is fitted to all samples from the first."""
    starts = first_guesses(evidence, bases, name, scrutiny)
    found = fits_from(evidence, bases, starts, name, scrutiny)
    if not found:
        return None, EXPLAINS_NOTHING
    best = _best_judged(evidence, found)
    if len(bases) > 1 and _does_harm(best, bases[0]):
        # The refit has misled it; from the nominal model it may go another way.
        starts = first_guesses(evidence, bases[-1:], name, scrutiny)
        anew = fits_from(evidence, bases[-1:], starts, name, scrutiny)
        best = _best_judged(evidence, best_first([best, *anew]))
    return best, ""


def _does_harm(best: Trial, base: Base) -> bool:
    """Whether a fit leaves far less than the base where fitted, and more where judged."""
    follows = best.fitted_rmse < FOLLOWS * base.trial.fitted_rmse
    return follows and best.rmse > base.trial.rmse


def _best_judged(evidence: Evidence, found: Sequence[Trial]) -> Trial:
    """The fit that leaves least of both kinds of samples; `found` has the best fitted first.

    One that has lost by the fitted samples alone is not judged.
    """
    trials: list[Trial] = []
    least = math.inf
    for fit in found:
        if evenly(0.0, fit.fitted_rmse) < least:
            trials.append(judged(evidence, fit))
            least = min(least, trials[-1].both)
    return min(trials, key=lambda trial: (math.isnan(trial.both), trial.both))


def behind(evidence: Evidence, trial: Trial, name: str) -> Trial:
    """A trial with an effect added that changes nothing in the fit."""
    model = with_guess(trial.model, name, registry()[name].starts(evidence.scales)[0])
    return judged(evidence, replace(trial, model=model))


def promise(
    evidence: Evidence, bases: Sequence[Base], name: str, found_alone: Sequence[Values]
) -> tuple[str, float]:
    """The share of a residual's power, at best, that is left when an effect joins in.

    `found_alone` is as `Scrutiny` has it.
    """
    try:
        with np.errstate(all="ignore"):
            part, anchors = on_a_part(evidence, bases, name, GLANCE)
            found = guesses(part, anchors, name, 1, found_alone)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return name, np.inf
    # A part has a beginning and a zero of its own, to which the base was not fitted.
    power = float(anchors[0].rest @ anchors[0].rest)
    return name, found[0].least / power if found and power > 0.0 else np.inf
