"""Strength by what it does: the oracle's residual without the effect, over the noise.

1 means that nothing is to be seen beyond the noise; weak, medium and strong are agreed ratios.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from microgripper_control.core.errors import MicrogripperError

RATIOS = {"weak": 1.5, "medium": 5.0, "strong": 30.0}
TOLERANCE = 0.03  # of the ratio
NOTICEABLE = 0.15  # excess over the noise from which it is taken to grow with the strength
STEP_UP = 8.0  # factor where nothing shows yet
MOST_TRIALS = 14
HALVING = 7  # trials after which the bracket alone decides


@dataclass(frozen=True)
class Found:
    """A strength and the ratio it gives; `reached` where that is the wanted one."""

    strength: float
    ratio: float
    reached: bool


def wanted_ratio(strength: str) -> float:
    """The ratio of a strength's name; MicrogripperError lists the names."""
    if strength not in RATIOS:
        raise MicrogripperError(f"rig: strength {strength!r}; known are {', '.join(RATIOS)}")
    return RATIOS[strength]


def excess(ratio: float) -> float:
    """What a ratio has beyond the noise, over the noise."""
    return math.sqrt(max(ratio**2 - 1.0, 0.0))


def search(
    ratio_at: Callable[[float], float],
    start: float,
    strongest: float,
    target: float,
    tolerance: float = TOLERANCE,
    trials: int = MOST_TRIALS,
) -> Found:
    """Find the strength whose ratio is `target`, which grows with it but need not be continuous.

    It begins at `start`. Where even `strongest` stays below, that is returned as not reached.
    """
    low, high = 0.0, math.inf
    best = Found(math.nan, math.inf, False)
    s = start
    for trial in range(trials):
        ratio = ratio_at(s)
        if abs(math.log(ratio / target)) < abs(math.log(best.ratio / target)):
            best = Found(s, ratio, abs(ratio / target - 1.0) <= tolerance)
        if best.reached or (ratio < target and s >= strongest):
            break
        low, high = (max(low, s), high) if ratio < target else (low, min(high, s))
        beyond = excess(ratio)
        s *= excess(target) / beyond if beyond > NOTICEABLE else STEP_UP
        if not low < s < high or (trial >= HALVING and math.isfinite(high)):
            s = math.sqrt(low * high) if low > 0.0 else 0.25 * high
        s = min(s, strongest)
    return best
