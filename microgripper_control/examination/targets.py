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
    """One demand: `value` must be at least, or at most, `limit`."""

    name: str
    text: str  # in plain words
    value: float
    low: float
    high: float
    of: int
    limit: float
    at_most: bool
    fewest: int = FEWEST

    @property
    def verdict(self) -> str:
        """MET, MISSED, or TOO_FEW cases to tell."""
        if self.of < self.fewest or math.isnan(self.value):
            return TOO_FEW
        reached = self.value <= self.limit if self.at_most else self.value >= self.limit
        return MET if reached else MISSED


def targets(score: Score) -> tuple[Target, ...]:
    """The demands in the order in which they are reported."""
    clear = Share(
        score.top["medium"].right + score.top["strong"].right,
        score.top["medium"].of + score.top["strong"].of,
    )
    cases = score.probability.of
    # A blank without an answer was asked for as well, and cannot be made up for.
    blanks = 150 - sum(case.blank and case.alarmed is None for case in score.cases)
    present = max(score.present, score.present_claimed, key=_error)
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
        _calibration("calibration_present", "present", present, cases),
    )


def _error(reliability: Reliability) -> float:
    return -1.0 if math.isnan(reliability.error) else reliability.error


def _share(name: str, text: str, share: Share, limit: float, at_most_of: int = 0) -> Target:
    low, high = share.interval
    fewest = at_most_of or FEWEST
    return Target(name, text, share.value, low, high, share.of, limit, bool(at_most_of), fewest)


def _middle(name: str, text: str, middle: Middle, limit: float) -> Target:
    return Target(name, text, middle.value, middle.low, middle.high, middle.of, limit, False)


def _calibration(name: str, what: str, found: Reliability, cases: int) -> Target:
    """Too few cases are those of which a calibrated diagnosis would miss it as well."""
    limit, (least, most) = 0.07, found.by_chance
    text = f"Expected calibration error of {what}"
    if found.of:
        text += f" (by chance {least:.2f} to {most:.2f})"
    fewest = cases + 1 if least > limit else FEWEST
    return Target(name, text, found.error, math.nan, math.nan, cases, limit, True, fewest)
