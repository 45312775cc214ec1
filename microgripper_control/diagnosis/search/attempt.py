"""One effect added to an explanation: from first guesses to the best fit, and why there is none.

Nothing that goes wrong with one effect stops the others: what cannot be fitted is told, not raised.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from microgripper_control.core.quantities import quantity
from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.data.grid import refuted
from microgripper_control.diagnosis.data.noise import removable
from microgripper_control.diagnosis.fits.fitting import ROUGH, Base, begun, extend, fit_on, half_way
from microgripper_control.diagnosis.fits.trial import (
    Trial,
    added,
    evenly,
    judged,
    moved,
    unfitted,
    with_guess,
)
from microgripper_control.diagnosis.search.beginning import begun_from_nothing
from microgripper_control.diagnosis.search.finishing import refined
from microgripper_control.diagnosis.search.labour import is_costly
from microgripper_control.diagnosis.search.screening import Guess, guesses, kind
from microgripper_control.diagnosis.search.stretches import GLANCE, MANY, on_a_part
from microgripper_control.effects.base import Values
from microgripper_control.effects.registry import registry

STARTS, MOST_STARTS = 2, 4  # best first guesses that are fitted,
ENOUGH = 60_000  # samples times guesses: few samples take many
STEPS = 9  # of a fit from a first guess, at most
FAR_OFF = 2.0  # times what is hopeless: what leaves more is not gone on with
CLOSE = 1.5  # times what is known: kinds of a law that leave more run no race
LITTLE_TAKEN = 0.99  # of a part's residual: if nothing is wanting, what leaves more is no way on
LITTLE_CLOSED = 0.9  # of the gap: a start that leaves more leads nowhere, if nothing is wanting
FALLEN_SHORT = 1.2  # times what a guess had promised: a fit that leaves more has gone astray
CLOSE_BEHIND = 1.2  # times what the best kind of a law leaves: another that is fitted on as well
ROUND_STEPS = 6  # of a round of a longer fit, all derivatives fresh
CARRIED = 2  # fits of a part of the samples that are tried on all; of an effect that joins, one
BEGINNING = 8  # steps with nothing but the h that recordings start with,
SETTLING_IN = 4  # and with the same derivatives, from a part of the samples to all of them
MISLED = 1.5  # times what is left of a part: if all leave more, as the part shows it, it misleads
FOLLOWS = 0.5  # of what the base leaves: a fit that leaves less has found something to follow
ROUNDS, FALLING = 5, 0.8  # of a long fit, as long as each leaves less than so much of the last


class Scrutiny(NamedTuple):
    """How far an effect is worth being fitted."""

    samples: int  # on which a costly one is fitted first
    starts: int = MOST_STARTS
    hopeless: float = math.inf  # m: what leaves more is fitted no further
    known: float = math.inf  # m, what the best of the others leaves
    found_alone: Sequence[Values] = ()  # what an effect that joins others was by itself

    def where_shown(self, base: float, shown: float) -> Scrutiny:
        """The same for a part that leaves `shown`, m, where the whole leaves the base: its share.

        Stretches with a zero of their own hide some of a gap. What leaves as great a share of what
        they show as is hopeless on the whole is as hopeless there.
        """
        if not base > self.hopeless:
            return self
        share = removable(self.hopeless, self.known) / removable(base, self.known)
        return self._replace(hopeless=math.hypot(self.known, share * removable(shown, self.known)))


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
        grid, error = evidence.grid, bases[0].trial.fitted_rmse
        if refuted(grid, error, [recording.measured for recording in evidence.fitted]):
            steps = quantity(grid.step, "m")
            return None, f"readings on steps of {steps} could not follow so closely"
        return behind(evidence, bases[0].trial, name), ""
    part, anchors = on_a_part(evidence, bases, name, scrutiny.samples)
    shown = rms([anchors[0].residual])
    scrutiny = scrutiny.where_shown(bases[0].trial.fitted_rmse, shown)
    starts = _starts(part, anchors, name, scrutiny)
    found = _from_all(part, anchors, starts, name, scrutiny)
    if not found:
        return None, "no first guess explains anything"
    found.sort(key=lambda trial: trial.fitted_rmse)
    if part is evidence:
        best = _best_judged(evidence, found)
        if len(bases) > 1 and _does_harm(best, bases[0]):
            # The refit has misled it; from the nominal model it may go another way.
            starts = _starts(evidence, bases[-1:], name, scrutiny)
            found = [best, *_from_all(evidence, bases[-1:], starts, name, scrutiny)]
            best = _best_judged(evidence, sorted(found, key=lambda trial: trial.fitted_rmse))
        return best, ""
    joins = bool(added(evidence, anchors[0].trial))
    if joins:
        found = found[:1]
    elif math.isfinite(scrutiny.hopeless) and found[0].fitted_rmse > _left_by_nothing(anchors[0]):
        return None, "takes nothing away of what a part of the samples shows"
    whole = _carried(evidence, bases[0], anchors[0], found, name, scrutiny)
    # A fit to a part may bend the base to what stretches hide: then all samples are asked.
    if joins and (whole is None or _is_misled(whole, found[0], bases[0], anchors[0])):
        anew = extend(evidence, bases[0], starts[0].model, [name])
        whole = _least([fit for fit in (whole, anew) if fit is not None])
    if whole is None:
        return None, "diverges where it was not fitted"
    return judged(evidence, whole), ""


def _starts(part: Evidence, anchors: Sequence[Base], name: str, scrutiny: Scrutiny) -> list[Guess]:
    """The first guesses that are fitted, the best first."""
    samples = sum(int(np.count_nonzero(used)) for used in part.used)
    wanted = min(scrutiny.starts, max(STARTS, ENOUGH // samples))
    return guesses(part, anchors, name, wanted, scrutiny.found_alone)


def _from_all(
    part: Evidence,
    anchors: Sequence[Base],
    starts: Sequence[Guess],
    name: str,
    scrutiny: Scrutiny,
) -> list[Trial]:
    """The fits from first guesses, and of an effect that is by itself their ends."""
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
    near = any(fit.fitted_rmse < too_far for fit in found)
    if not (alone and near):
        return found
    return [*found, *_gone_on_with(part, found, name, scrutiny)]


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
    return [*longer, *(_while_it_falls(part, fit, steps) for fit in running)]


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


def _left_by_nothing(base: Base) -> float:
    """What a fit to a part leaves, m, or more, that takes nothing away: on all it would do harm."""
    return LITTLE_TAKEN * rms([base.residual])


def _with_little_closed(base: Base, known: float) -> float:
    """What is left, m, where hardly more is closed of a gap that the best of the others closes."""
    return math.hypot(known, LITTLE_CLOSED * removable(rms([base.residual]), known))


def _carried(
    evidence: Evidence,
    base: Base,
    anchor: Base,
    found: Sequence[Trial],
    name: str,
    scrutiny: Scrutiny,
) -> Trial | None:
    """The best fit on all samples of those that were found on a part, best first.

    `anchor` is the base on the part. Where that has misled an effect which is by itself, the best
    of each kind is fitted anew. None if all diverge.
    """
    least = found[0].fitted_rmse
    if least >= scrutiny.hopeless:
        return _on_all(evidence, base, found[:1])
    # What fits a part best may have bent to it: elsewhere it fits worse, or diverges.
    whole = _on_all(evidence, base, found[:CARRIED])
    if whole is None:
        return None
    whole = fit_on(evidence, whole, ROUGH, SETTLING_IN, fresh=())
    joins = bool(added(evidence, base.trial))
    if joins or least >= scrutiny.known or not _is_misled(whole, found[0], base, anchor):
        return whole
    # Stretches do not show a force what it remembers from before them: where its memory is long,
    # the way back from what they made of it is long as well.
    more = evidence.pieces(MANY)
    others = [moved(more, fit) for fit in best_of_each_kind(found, name)]
    further = _least([_while_it_falls(more, fit, ROUND_STEPS) for fit in others])
    if further is not None and more is not evidence:
        further = _on_all(evidence, base, [further])
        further = further and fit_on(evidence, further, ROUGH, SETTLING_IN, fresh=())
    return _least([fit for fit in (whole, further) if fit is not None])


def _is_misled(whole: Trial, found: Trial, base: Base, anchor: Base) -> bool:
    """Whether all samples leave clearly more than a fit to a part, as far as that shows the gap."""
    shown = rms([anchor.residual]) / base.trial.fitted_rmse
    return whole.fitted_rmse * shown > MISLED * found.fitted_rmse


def _on_all(evidence: Evidence, base: Base, fits: Sequence[Trial]) -> Trial | None:
    """The best on all samples of what was fitted to a part, not fitted on; None if all diverge.

    Recordings start with the h of the base, but for what the best of them makes of it: a base may
    have made up for what it did not know.
    """
    known = base.trial.initial_hysteresis
    best = _least([unfitted(evidence, replace(fit, initial_hysteresis=known)) for fit in fits])
    if best is None:
        return None
    settled = fit_on(evidence, replace(best, free=()), ROUGH, BEGINNING)
    return replace(settled, free=best.free)


def _while_it_falls(evidence: Evidence, trial: Trial, steps: int) -> Trial:
    """Fit on in rounds of some steps, as long as each leaves clearly less than the one before."""
    left = math.inf
    for _ in range(ROUNDS):
        trial = fit_on(evidence, trial, ROUGH, steps)
        if not trial.fitted_rmse < FALLING * left:
            break
        left = trial.fitted_rmse
    return trial


def _least(trials: Sequence[Trial]) -> Trial | None:
    sound = [trial for trial in trials if np.isfinite(trial.fitted_rmse)]
    return min(sound, key=lambda trial: trial.fitted_rmse, default=None)


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


def polish(evidence: Evidence, trial: Trial) -> Trial:
    """Fit on with fresh derivatives, in rounds as long as each leaves clearly less."""
    for _ in range(ROUNDS):
        before = trial.fitted_rmse
        trial = refined(evidence, trial, ROUGH, STEPS)
        if not trial.fitted_rmse < FALLING * before:
            break
    return trial
