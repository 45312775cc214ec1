"""Noise that is not white: each sample tells of the next few, and no voltage of any.

A sensor's filter makes such noise, and outliers are heavier than what is usual. To the innovation
both look like a gap. What a missing law leaves is another thing: it follows from the voltage, or
lasts longer than a few samples.
"""

from __future__ import annotations

from microgripper_control.diagnosis.answers.weighing import explained
from microgripper_control.diagnosis.data.noise import innovation
from microgripper_control.diagnosis.data.residuals import residuals_of
from microgripper_control.diagnosis.fits.trial import added
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.signs.freeform import explainable

AHEAD = 10  # samples after which noise is forgotten
HARDLY = 0.2  # of what is left: if more of it follows from the voltage, it is no noise
MOST = 1.5  # times the innovation: what leaves more is no matter of colour


def coloured_noise(pool: Pool) -> float:
    """What of the best explanation's errors nothing could predict AHEAD samples before, m rms.

    0 where it leaves much more than what is new in each sample, or what follows from the voltage.
    """
    best = pool.leader
    if explained(added(pool.evidence, best), best, pool).judged > MOST * pool.noise_floor:
        return 0.0
    left = residuals_of(pool.evidence, best.model)
    if explainable(left.fitted, left.judging, pool.noise_floor) > HARDLY:
        return 0.0
    return min(best.rmse, innovation(best.errors, AHEAD))
