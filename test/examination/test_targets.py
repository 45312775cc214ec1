"""Each demand against its limit, and calibration errors against chance."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.examination.calibration import Reliability, reliability
from microgripper_control.examination.score import Score, scored
from microgripper_control.examination.targets import MET, MISSED, TOO_FEW, targets


@pytest.fixture(scope="module")
def empty() -> Score:
    return scored([])


def verdict(score: Score, name: str) -> str:
    return {target.name: target.verdict for target in targets(score)}[name]


def calibrated(cases: int, seed: int) -> Reliability:
    """Of claims that come true just as often as they say."""
    generator = np.random.default_rng(seed)
    given = generator.uniform(0.3, 1.0, cases)
    return reliability(list(zip(given, generator.random(cases) < given, strict=True)))


def of(error: float, most: float, claims: int = 40) -> Reliability:
    return Reliability((), error, (0.5 * most, most), claims)


@pytest.mark.parametrize("cases", [40, 100])
def test_a_calibrated_diagnosis_does_not_miss_the_demand(empty: Score, cases: int) -> None:
    drawn = [replace(empty, probability=calibrated(cases, seed)) for seed in range(100)]
    found = Counter(verdict(score, "calibration_probability") for score in drawn)
    assert found[MISSED] <= 6  # above what 97.5 % of them show
    assert found[TOO_FEW] > 30


@pytest.mark.parametrize(
    ("error", "most", "expected"),
    [
        (0.070, 0.03, MET),
        (0.071, 0.03, MISSED),
        (0.071, 0.08, TOO_FEW),
        (0.081, 0.08, MISSED),
        (0.069, 0.20, MET),
    ],
)
def test_an_error_is_missed_above_the_limit_and_chance(
    empty: Score, error: float, most: float, expected: str
) -> None:
    score = replace(empty, probability=of(error, most))
    assert verdict(score, "calibration_probability") == expected
    few = replace(empty, probability=of(error, most, claims=29))
    assert verdict(few, "calibration_probability") == TOO_FEW


@pytest.mark.parametrize(
    ("present", "claimed", "expected"),
    [
        (of(0.02, 0.01), of(0.09, 0.05), MISSED),
        (of(0.02, 0.01), of(0.09, 0.20), TOO_FEW),
        (of(0.08, 0.01), of(0.09, 0.20), MISSED),
        (of(0.02, 0.01), reliability([]), MET),
        (of(0.02, 0.01), of(0.03, 0.20), MET),
    ],
)
def test_the_worse_error_of_present_is_held_against_the_demand(
    empty: Score, present: Reliability, claimed: Reliability, expected: str
) -> None:
    probability = of(0.0, 0.1)
    score = replace(empty, probability=probability, present=present, present_claimed=claimed)
    assert verdict(score, "calibration_present") == expected
