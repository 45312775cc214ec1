"""From an effect's first guesses to its fits, on the samples at hand.

A few steps from each guess, then longer ones where they can still win.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.data.noise import removable
from microgripper_control.diagnosis.fits.fitting import ROUGH, Base, begun, extend, fit_on, half_way
from microgripper_control.diagnosis.fits.trial import Trial, added
from microgripper_control.diagnosis.search.finishing import ROUND_STEPS, STEPS, while_it_falls
from microgripper_control.diagnosis.search.labour import is_costly
from microgripper_control.diagnosis.search.screening import Guess, guesses, kind
from microgripper_control.diagnosis.search.scrutiny import STARTS, Scrutiny

EXPLAINS_NOTHING = "no first guess explains anything"
ENOUGH = 60_000  # samples times guesses: few samples take many
FAR_OFF = 2.0  # times what is hopeless: what leaves more is not gone on with
CLOSE = 1.5  # times what is known: kinds of a law that leave more run no race
LITTLE_CLOSED = 0.9  # of the gap: a start that leaves more leads nowhere, if nothing is wanting
FALLEN_SHORT = 1.2  # times what a guess had promised: a fit that leaves more has gone astray
CLOSE_BEHIND = 1.2  # times what the best kind of a law leaves: another that is fitted on as well


def first_guesses(
    part: Evidence, anchors: Sequence[Base], name: str, scrutiny: Scrutiny
) -> list[Guess]:
    """The first guesses that are fitted, the best first."""
    samples = sum(int(np.count_nonzero(used)) for used in part.used)
    wanted = min(scrutiny.starts, max(STARTS, ENOUGH // samples))
    return guesses(part, anchors, name, wanted, scrutiny.found_alone)


def fits_from(
    part: Evidence,
    anchors: Sequence[Base],
    starts: Sequence[Guess],
    name: str,
    scrutiny: Scrutiny,
) -> list[Trial]:
    """The fits from first guesses, and of an effect that is by itself their ends; best first."""
    alone = not added(part, anchors[0].trial)
    too_far = FAR_OFF * scrutiny.hopeless
    if alone and math.isfinite(too_far):
        too_far = min(too_far, _with_little_closed(anchors[0], scrutiny.known))
    # What promises much may still overshoot at first.
    limits = [too_far if guess.hoped > scrutiny.hopeless else math.inf for guess in starts]
    fits = [
        _fit_from(part, guess, name, limit) for guess, limit in zip(starts, limits, strict=True)
    ]
    found = [fit for fit in fits if fit is not None and np.isfinite(fit.fitted_rmse)]
    if alone and any(fit.fitted_rmse < too_far for fit in found):
        found += _gone_on_with(part, found, name, scrutiny)
    return best_first(found)


def _gone_on_with(
    part: Evidence, found: Sequence[Trial], name: str, scrutiny: Scrutiny
) -> list[Trial]:
    """Longer fits of the best of each kind: of a costly effect's, and of all in a close race.

    The kind that is ahead after a few steps need not be the rig's, so those close to it are fitted
    as long as they fall; but a race that is only won where it is hopeless, or far off, is not run.
    """
    best = best_of_each_kind(found, name)
    longer: list[Trial] = []
    steps = STEPS
    if any(is_costly(part, fit.model) for fit in found):
        steps = ROUND_STEPS
        best = longer = [fit_on(part, fit, ROUGH, steps) for fit in best]
    least = min(fit.fitted_rmse for fit in best)
    running = [fit for fit in best if fit.fitted_rmse <= CLOSE_BEHIND * least]
    if len(running) < 2 or least > min(CLOSE * scrutiny.known, scrutiny.hopeless):
        return longer
    return [*longer, *(while_it_falls(part, fit, steps) for fit in running)]


def _with_little_closed(base: Base, known: float) -> float:
    """What is left, m, where hardly more is closed of a gap that the best of the others closes."""
    return math.hypot(known, LITTLE_CLOSED * removable(rms([base.residual]), known))


def best_first(found: Sequence[Trial]) -> list[Trial]:
    """Trials by what they leave where they were fitted."""
    return sorted(found, key=lambda trial: trial.fitted_rmse)


def best_of_each_kind(found: Sequence[Trial], name: str) -> list[Trial]:
    """A law may have parts of which a fit takes one: the one that ends lower may begin higher."""
    best = sorted(found, key=lambda trial: trial.fitted_rmse, reverse=True)
    return list({kind(fit.model, name): fit for fit in best}.values())


def _fit_from(evidence: Evidence, guess: Guess, name: str, too_far: float) -> Trial | None:
    """Fit from a first guess: with few derivatives fresh, then, where it costs little, with all.

    All at once from the guess would often lead astray, few of them alone far too little. Where less
    comes of it than the guess had promised, the base's parameters go first.
    """
    fit = extend(evidence, guess.base, guess.model, [name])
    if is_costly(evidence, guess.model) or (fit is not None and fit.fitted_rmse > too_far):
        return fit
    fit = fit_on(evidence, fit or begun(guess.base, guess.model, [name]), ROUGH, STEPS)
    if fit.fitted_rmse < FALLEN_SHORT * guess.promised:
        return fit
    start = half_way(evidence, guess.base, guess.model, [name])
    if start is None:
        return fit
    other = fit_on(evidence, start, ROUGH, STEPS)
    return min(fit, other, key=lambda trial: trial.fitted_rmse)
