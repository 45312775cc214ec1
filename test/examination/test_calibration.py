"""Calibration errors computed by hand."""

from __future__ import annotations

import math

import pytest
from hand_made import diagnosis, marked

from microgripper_control.examination.calibration import answers, presences, reliability


def test_the_error_is_the_mean_distance_of_the_bins() -> None:
    claims = [(0.92, True), (0.98, False), (0.55, True), (0.05, False)]
    found = reliability(claims)
    # [0.9, 1): mean 0.95, half came true; [0.5, 0.6): 0.55, all; [0, 0.1): 0.05, none.
    assert found.error == pytest.approx((2 * 0.45 + 0.45 + 0.05) / 4)
    assert [(one.low, one.share.right, one.share.of) for one in found.bins] == [
        (0.0, 0, 1),
        (0.5, 1, 1),
        (0.9, 1, 2),
    ]


def test_perfect_claims_have_no_error_and_none_have_none() -> None:
    assert reliability([(0.5, True), (0.5, False), (1.0, True)]).error == pytest.approx(0.0)
    assert math.isnan(reliability([]).error)


def test_few_claims_show_an_error_by_chance_and_sure_ones_none() -> None:
    # One claim of 0.3 is 0.3 or 0.7 off; of 400 in one bin the share is normal about 0.3.
    assert reliability([(0.3, False)]).by_chance == pytest.approx((0.3, 0.7))
    low, high = reliability([(0.3, False)] * 400).by_chance
    spread = math.sqrt(0.3 * 0.7 / 400)
    assert low == pytest.approx(0.03 * spread, abs=0.15 * spread)
    assert high == pytest.approx(2.24 * spread, rel=0.1)  # of |z|, 97.5 %
    assert reliability([(1.0, True), (0.0, False)]).by_chance == (0.0, 0.0)


def test_the_top_answer_is_held_against_the_truth() -> None:
    cases = [
        marked(("creep",), diagnosis(("creep",), 0.8)),
        marked(("creep",), diagnosis(("backlash",), 0.7)),
        marked(("none",), diagnosis(("none",), 0.6)),
        marked(("creep", "backlash"), diagnosis(("backlash", "creep"), 0.9), "pairs"),
        marked(("creep",), None),
        marked(("creep",), diagnosis(("none",)), seen=False),
    ]
    assert answers(cases) == [(0.8, True), (0.7, False), (0.6, True), (0.9, False)]


def test_present_counts_effects_alone_and_not_what_cannot_be_seen() -> None:
    case = marked(("creep",), diagnosis(("creep", "backlash"), 0.8))
    assert presences([case]) == [(0.8, True), (0.8, False)]
    assert presences([case], least=0.85) == []
    hidden = marked(("creep",), diagnosis(("creep", "backlash"), 0.8), seen=False)
    assert presences([hidden]) == [(0.8, False)]
