"""A fit to a part of the samples, carried to all of them.

Where each sample is costly, stretches of the recordings are fitted first. What bends to them may
fit worse elsewhere, or diverge; then all samples are asked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.fits.fitting import ROUGH, Base, extend, fit_on
from microgripper_control.diagnosis.fits.trial import Trial, added, judged, moved, unfitted
from microgripper_control.diagnosis.search.finishing import ROUND_STEPS, while_it_falls
from microgripper_control.diagnosis.search.from_guesses import (
    EXPLAINS_NOTHING,
    best_of_each_kind,
    first_guesses,
    fits_from,
)
from microgripper_control.diagnosis.search.scrutiny import Scrutiny
from microgripper_control.diagnosis.search.stretches import MANY

LITTLE_TAKEN = 0.99  # of a part's residual: if nothing is wanting, what leaves more is no way on
CARRIED = 2  # fits of a part of the samples that are tried on all; of an effect that joins, one
BEGINNING = 8  # steps with nothing but the h that recordings start with,
SETTLING_IN = 4  # and with the same derivatives, from a part of the samples to all of them
MISLED = 1.5  # times what is left of a part: if all leave more, as the part shows it, it misleads


def by_way_of_a_part(
    evidence: Evidence,
    base: Base,
    part: Evidence,
    anchors: Sequence[Base],
    name: str,
    scrutiny: Scrutiny,
) -> tuple[Trial | None, str]:
    """The best fit of an effect that is fitted to a part first, and why there is none.

    `anchors` are the bases on the part, of which the first is `base` on all samples.
    """
    starts = first_guesses(part, anchors, name, scrutiny)
    found = fits_from(part, anchors, starts, name, scrutiny)
    if not found:
        return None, EXPLAINS_NOTHING
    joins = bool(added(evidence, anchors[0].trial))
    if joins:
        found = found[:1]
    elif math.isfinite(scrutiny.hopeless) and found[0].fitted_rmse > _left_by_nothing(anchors[0]):
        return None, "takes nothing away of what a part of the samples shows"
    whole = _carried(evidence, base, anchors[0], found, name, scrutiny)
    # A fit to a part may bend the base to what stretches hide: then all samples are asked.
    if joins and (whole is None or _is_misled(whole, found[0], base, anchors[0])):
        anew = extend(evidence, base, starts[0].model, [name])
        whole = _least([fit for fit in (whole, anew) if fit is not None])
    if whole is None:
        return None, "diverges where it was not fitted"
    return judged(evidence, whole), ""


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
    further = _least([while_it_falls(more, fit, ROUND_STEPS) for fit in others])
    if further is not None and more is not evidence:
        further = _on_all(evidence, base, [further])
        further = further and fit_on(evidence, further, ROUGH, SETTLING_IN, fresh=())
    return _least([fit for fit in (whole, further) if fit is not None])


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


def _left_by_nothing(base: Base) -> float:
    """What a fit to a part leaves, m, or more, that takes nothing away: on all it would do harm."""
    return LITTLE_TAKEN * rms([base.residual])


def _is_misled(whole: Trial, found: Trial, base: Base, anchor: Base) -> bool:
    """Whether all samples leave clearly more than a fit to a part, as far as that shows the gap."""
    shown = rms([anchor.residual]) / base.trial.fitted_rmse
    return whole.fitted_rmse * shown > MISLED * found.fitted_rmse


def _least(trials: Sequence[Trial]) -> Trial | None:
    sound = [trial for trial in trials if np.isfinite(trial.fitted_rmse)]
    return min(sound, key=lambda trial: trial.fitted_rmse, default=None)
