"""Ranges against the rig's own."""

from __future__ import annotations

import pytest
from hand_made import CONTACT, diagnosis, marked

from microgripper_control.examination.places import places, same
from microgripper_control.examination.sealed import Span
from microgripper_control.examination.shares import Share


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(10e-6, 20e-6, True), (14e-6, 30e-6, True), (16e-6, 30e-6, False), (19e-6, 19.5e-6, True)],
)
def test_half_of_the_shorter_range_must_be_shared(low: float, high: float, expected: bool) -> None:
    assert same(Span("displacement_m", low, high), CONTACT) is expected
    assert not same(Span("voltage_V", low, high), CONTACT)


@pytest.mark.parametrize(
    ("claimed", "expected"),
    [
        (Span("frequency_Hz", 0.0, 500.0), False),
        (Span("frequency_Hz", 45.5, 54.1), True),
        (Span("displacement_m", 2e-6, 20e-6), False),
        (Span("displacement_m", 12e-6, 20e-6), True),
    ],
)
def test_a_claimed_range_must_not_be_much_longer(claimed: Span, expected: bool) -> None:
    true = {
        "frequency_Hz": Span("frequency_Hz", 49.5, 50.5),
        "displacement_m": Span("displacement_m", 15e-6, 20e-6),
    }
    assert same(claimed, true[claimed.axis]) is expected


def test_precision_counts_the_axes_of_the_truth_and_recall_the_true_ranges() -> None:
    said = (CONTACT, Span("displacement_m", 0.0, 1e-6), Span("voltage_V", 80.0, 160.0))
    cases = [
        marked(("contact",), diagnosis(("contact",), where=said), where=(CONTACT,)),
        marked(("contact",), diagnosis(("contact",)), where=(CONTACT,)),
        marked(("creep",), diagnosis(("creep",), where=said)),
    ]
    found = places(cases)
    assert (found.precision, found.recall) == (Share(1, 2), Share(1, 2))
    assert found.elsewhere == 1


def test_a_case_without_an_answer_has_found_no_place() -> None:
    right = marked(("contact",), diagnosis(("contact",), where=(CONTACT,)), where=(CONTACT,))
    unanswered = marked(("contact",), None, where=(CONTACT,))
    found = places([right, *[unanswered] * 9])
    assert (found.precision, found.recall) == (Share(1, 1), Share(1, 10))
