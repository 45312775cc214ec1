"""Whether the recordings fit far better when the voltage is taken to run otherwise in between.

Half a sample is 18 degrees of phase at a tenth of the sampling rate: a wrong setting looks like a
delay or a lag of the rig.
"""

from __future__ import annotations

from dataclasses import replace

from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import ROUGH, refine
from microgripper_control.diagnosis.fits.trial import Trial, unfitted
from microgripper_control.plant.hold import Hold

FAR_BETTER = 0.6  # of the error that the chosen setting leaves


def hold_warnings(evidence: Evidence, refit: Trial) -> tuple[str, ...]:
    """One line for the setting under which a refit leaves far less, if there is one."""
    chosen = evidence.conditions.hold
    best, least = chosen, refit.rmse
    for hold in Hold:
        if hold is chosen:
            continue
        other = replace(evidence, conditions=replace(evidence.conditions, hold=hold))
        found = refine(other, unfitted(other, refit), ROUGH, 6)
        if found.rmse < least:
            best, least = hold, found.rmse
    if least > FAR_BETTER * refit.rmse:
        return ()
    return (
        f"under --hold {best.value} a refit leaves {1e9 * least:.1f} nm, under --hold "
        f"{chosen.value} {1e9 * refit.rmse:.1f} nm: make sure how the voltage ran between its "
        "samples before you believe in a delay or a lag",
    )
