"""What the residual does while the voltage is held: creep goes on, a wrong gain does not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.diagnosis.data.residuals import Residual

FEWEST = 3  # holds
SMALLEST = 1e-3  # of the range: a step below it tells nothing about what follows


@dataclass(frozen=True)
class Growth:
    """How the error goes on after steps of the voltage, in the direction of the step."""

    per_decade: float  # of the step's displacement, for ten times the time
    explained: float  # of what changes during the holds
    certainty: float  # per_decade over its scatter from hold to hold
    holds: int
    longest: float  # s


def growth_in_holds(residuals: Sequence[Residual], after: float) -> Growth | None:
    """The logarithmic growth over holds longer than five times `after`, s; None for too few."""
    slopes, weights, changes, explained, longest = [], [], 0.0, 0.0, 0.0
    for residual in residuals:
        still = residual.hold_time
        for hold in residual.holds(5.0 * after):
            before = max(0, hold.start - max(2, round(after / residual.period)))
            predicted = residual.predicted
            step = float(predicted[hold.stop - 1] - predicted[before])
            seen = residual.recording.counting[hold]
            late = np.arange(hold.start, hold.stop)[seen & (still[hold] >= after)]
            if len(late) < 20 or abs(step) < SMALLEST * float(np.ptp(predicted)):
                continue
            decades = np.log10(still[late])
            decades = decades - decades.mean()
            error = residual.error[late] - residual.error[late].mean()
            spread = float(decades @ decades)
            slopes.append(float(decades @ error) / spread / step)
            weights.append(spread * step**2)
            scatter = float(np.mean(np.diff(error) ** 2)) / 2.0
            changes += max(float(error @ error) - scatter * len(error), 0.0)
            longest = max(longest, float(still[late[-1]]))
    if len(slopes) < FEWEST or changes <= 0.0:
        return None
    slope, weight = np.array(slopes), np.array(weights)
    mean = float(slope @ weight / weight.sum())
    explained = mean**2 * float(weight.sum()) / changes
    variance = float(weight**2 @ (slope - mean) ** 2) / float(weight.sum()) ** 2
    certainty = abs(mean) / float(np.sqrt(max(variance, 1e-300)))
    return Growth(mean, min(1.0, explained), certainty, len(slopes), longest)
