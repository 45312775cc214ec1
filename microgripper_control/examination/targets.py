"""What must hold, and whether it does."""

from __future__ import annotations

import math
from dataclasses import dataclass

from microgripper_control.examination.calibration import Reliability
from microgripper_control.examination.score import Score
from microgripper_control.examination.shares import Middle, Share

MET, MISSED, TOO_FEW = "met", "not met", "too few cases"
FEWEST = 30  # cases below which a share says nothing


@dataclass(frozen=True)
class Target:
    """One demand: `value` must be at least, or at most, `limit`.

    An error of no more than `by_chance` is one that a diagnosis without fault shows as well of so
    few cases: above the limit it tells nothing.
    """

    name: str
    text: str  # in plain words
    value: float
    low: float
    high: float
    of: int
    limit: float
    at_most: bool
    fewest: int = FEWEST
    by_chance: float = math.nan  # the same as `value`; NaN where nothing is asked of chance

    @property
    def verdict(self) -> str:
        """MET, MISSED, or TOO_FEW cases to tell."""
        if self.of < self.fewest or math.isnan(self.value):
            return TOO_FEW
        if self.value <= self.limit if self.at_most else self.value >= self.limit:
            return MET
        return TOO_FEW if self.value <= self.by_chance else MISSED


def targets(score: Score) -> tuple[Target, ...]:
    """The demands in the order in which they are reported."""
    clear = Share(
        score.top["medium"].right + score.top["strong"].right,
        score.top["medium"].of + score.top["strong"].of,
    )
    cases = score.probability.of
    # A blank without an answer was asked for as well, and cannot be made up for.
    blanks = 150 - sum(case.blank and case.alarmed is None for case in score.cases)
    present = (
        _calibration("calibration_present", "present", found, cases)
        for found in (score.present, score.present_claimed)
    )
    return (
        _share("top_1", "Effect named, medium and strong", clear, 0.95),
        _share("top_1_weak", "Effect named, weak", score.top["weak"], 0.80),
        _share("stage", "Stage found", score.stage, 0.97),
        _share(
            "false_alarms", "False alarms on none and parameters", score.false_alarms, 0.02, blanks
        ),
        _share("unknown", "Unknown where the library has not the cause", score.unknown, 0.85),
        _middle("gap_closed", "Gap closed, of what the oracle closes (median)", score.closed, 0.90),
        _calibration("calibration_probability", "probability", score.probability, cases),
        max(present, key=_badness),
    )


def _badness(error: Target) -> tuple[bool, float]:
    """One that is missed is worse than a larger one that chance may have made."""
    return error.verdict == MISSED, -1.0 if math.isnan(error.value) else error.value


def _share(name: str, text: str, share: Share, limit: float, at_most_of: int = 0) -> Target:
    low, high = share.interval
    fewest = at_most_of or FEWEST
    return Target(name, text, share.value, low, high, share.of, limit, bool(at_most_of), fewest)


def _middle(name: str, text: str, middle: Middle, limit: float) -> Target:
    return Target(name, text, middle.value, middle.low, middle.high, middle.of, limit, False)


def _calibration(name: str, what: str, found: Reliability, cases: int) -> Target:
    least, most = found.by_chance
    text = f"Expected calibration error of {what}"
    if found.of:
        text += f" (by chance {least:.2f} to {most:.2f})"
    return Target(name, text, found.error, math.nan, math.nan, cases, 0.07, True, by_chance=most)
