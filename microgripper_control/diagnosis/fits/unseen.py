"""A gap that only the held-out recordings show: a rate, a level, a position the others never reach.

What is fitted elsewhere cannot tell its cause. Then the odd blocks of the held-out recordings are
fitted as well, and the even ones judge.
"""

from __future__ import annotations

from microgripper_control.core.quantities import quantity
from microgripper_control.diagnosis.data.evidence import MOST_SIMULATED, Evidence
from microgripper_control.diagnosis.data.grid import rounding
from microgripper_control.diagnosis.data.noise import quietest, removable
from microgripper_control.diagnosis.data.residuals import fitted_residuals
from microgripper_control.diagnosis.fits.trial import Trial

SHOWN = 0.3  # of the gap on the held-out recordings: the others show it if theirs is larger,
CLEAR = 3.0  # or if it is more than so many times the noise floor
REAL = 0.5  # of the noise floor: a smaller gap is not looked for


def unseen_gap(evidence: Evidence, refit: Trial) -> bool:
    """Whether the refitted model fails on the held-out recordings by what the fit never saw."""
    if not evidence.separate or _samples(evidence) > MOST_SIMULATED:
        return False
    fitted = fitted_residuals(evidence, refit.model)
    # A large gap, or what each step leaves, lets an innovation seem larger than the noise is.
    usual = quietest([one.error[one.counted] for one in fitted])
    floor = min(refit.noise_floor, max(usual, rounding(evidence.scales.resolution)))
    gap, seen = removable(refit.rmse, floor), removable(refit.fitted_rmse, floor)
    return gap > REAL * floor and seen < min(SHOWN * gap, CLEAR * floor)


def unseen_warning(refit: Trial) -> str:
    """What the user is told then; `refit` is that to the other recordings alone."""
    return (
        f"only the held-out recordings show the gap: {quantity(refit.rmse, 'm')} are left there, "
        f"{quantity(refit.fitted_rmse, 'm')} in the others; half of their blocks were fitted, too, "
        "and the other half judges"
    )


def _samples(evidence: Evidence) -> int:
    return sum(len(recording) for recording in (*evidence.fitted, *evidence.judged))
