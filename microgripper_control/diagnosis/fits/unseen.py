"""A gap that only what judges shows: a rate, a level, a position that is not reached elsewhere.

What is fitted elsewhere cannot tell its cause. Then a part of what judges is fitted as well, and
the rest judges (`Evidence.joined`).
"""

from __future__ import annotations

from microgripper_control.core.quantities import quantity
from microgripper_control.diagnosis.data.evidence import MOST_SIMULATED, Evidence
from microgripper_control.diagnosis.data.noise import quietest, removable
from microgripper_control.diagnosis.data.residuals import fitted_residuals
from microgripper_control.diagnosis.fits.trial import Trial

SHOWN = 0.3  # of the gap where it is judged: elsewhere it shows if it is larger there,
SHOWN_IN_BLOCKS = 0.5  # the same of blocks of one recording, which should be of one kind,
CLEAR = 3.0  # or if it is more than so many times the noise floor
REAL = 0.5  # of the noise floor: a smaller gap is not looked for


def unseen_gap(evidence: Evidence, trial: Trial) -> bool:
    """Whether a fitted model fails where it is judged by what the fit never saw."""
    if _samples(evidence) > MOST_SIMULATED:
        return False
    fitted = fitted_residuals(evidence, trial.model)
    # A large gap, or what each step leaves, lets an innovation seem larger than the noise is.
    usual = quietest([one.error[one.counted] for one in fitted])
    floor = min(trial.noise_floor, max(usual, evidence.grid.rounding))
    gap, seen = removable(trial.rmse, floor), removable(trial.fitted_rmse, floor)
    shown = SHOWN if evidence.separate else SHOWN_IN_BLOCKS
    return gap > REAL * floor and seen < min(shown * gap, CLEAR * floor)


def unseen_warning(evidence: Evidence, trial: Trial) -> str:
    """What the user is told then; both are those before more was fitted."""
    whose, part = "blocks", "half of each was"
    if evidence.separate:
        whose, part = "recordings", "half of their blocks were"
    return (
        f"only the held-out {whose} show the gap: before any of it was fitted, the best fit left "
        f"{quantity(trial.rmse, 'm')} there, {quantity(trial.fitted_rmse, 'm')} in the others; "
        f"{part} fitted, too, and the errors told are of the other half"
    )


def _samples(evidence: Evidence) -> int:
    """How many samples there are; blocks that judge are of recordings that are fitted as well."""
    each = {id(recording): len(recording) for recording in (*evidence.fitted, *evidence.judged)}
    return sum(each.values())
