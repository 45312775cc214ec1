"""What is right and what is wrong, rule by rule."""

from __future__ import annotations

import pytest
from hand_made import diagnosis, marked

from microgripper_control.examination.confusions import reason
from microgripper_control.examination.equals import AGREE
from microgripper_control.examination.marking import NO_ANSWER

GROUP = (("amplifier_lag", "sensor_lag"),)
LAG, OTHER = ("amplifier_lag",), ("sensor_lag",)


def test_the_effect_that_stands_first_is_the_answer() -> None:
    case = marked(("creep",), diagnosis(("creep", "backlash")))
    assert (case.right, case.stage_right, case.further) == (True, True, True)
    case = marked(("creep",), diagnosis(("backlash", "creep")))
    assert (case.right, case.stage_right) == (False, False)


def test_another_effect_of_the_same_stage_has_the_stage_right() -> None:
    case = marked(("creep",), diagnosis(("rate_dependent_hysteresis",)))
    assert (case.right, case.stage_right) == (False, True)


@pytest.mark.parametrize(("excess", "right"), [(0.9 * AGREE, True), (1.1 * AGREE, False)])
@pytest.mark.parametrize("said", [LAG, OTHER])
def test_a_group_is_right_where_the_oracles_agree(
    said: tuple[str, ...], excess: float, right: bool
) -> None:
    case = marked(LAG, diagnosis(said, groups=GROUP), rivals={"sensor_lag": excess})
    assert case.right is right
    assert case.first is (said == LAG)
    assert case.groups == [right]


def test_a_group_nobody_can_judge_is_wrong() -> None:
    assert marked(LAG, diagnosis(LAG, groups=GROUP), rivals={"sensor_lag": None}).right is False


def test_a_group_that_was_not_asked_about_is_left_out() -> None:
    groups = (("creep", "backlash"), ("creep", "contact", "friction"))
    answer = diagnosis(("creep",), groups=groups)
    case = marked(("creep",), answer, rivals={"backlash": 2.0, "contact": 0.1})
    assert (case.groups, case.right) == ([False, None], False)
    case = marked(("creep",), answer, rivals={"backlash": 0.1, "contact": 2.0})
    assert case.groups == [True, False]


def test_oracles_that_agree_excuse_no_one_who_did_not_name_the_group() -> None:
    case = marked(LAG, diagnosis(OTHER), rivals={"sensor_lag": 0.1})
    assert case.right is False
    assert "were not named together" in reason(case)


def test_an_effect_that_cannot_be_seen_is_not_asked_for() -> None:
    case = marked(("creep",), diagnosis(("parameters",)), ratio=1.1, seen=False)
    assert (case.asked, case.right, case.keeps_quiet) == (None, None, True)
    for said, quiet in (("creep", True), ("contact", False), ("unknown", False)):
        case = marked(("creep",), diagnosis((said,)), ratio=1.1, seen=False)
        assert case.keeps_quiet is quiet
    assert not marked(("creep",), None, ratio=1.1, seen=False).keeps_quiet


@pytest.mark.parametrize("question", ["withheld", "never"])
def test_a_cause_outside_the_library_is_unknown(question: str) -> None:
    effects = ("creep",) if question == "withheld" else ("supply_sag",)
    assert marked(effects, diagnosis(("unknown",)), question).right is True
    assert marked(effects, diagnosis(("backlash",)), question).right is False
    hidden = marked(effects, diagnosis(("none",)), question, ratio=2.0)
    assert hidden.right is None  # e = sqrt(3) of the noise: not above twice


def test_a_stand_in_must_be_equivalent_and_not_given_as_probable() -> None:
    for probability, excess, stands_in in ((0.4, 0.3, True), (0.9, 0.3, False), (0.4, 2.0, False)):
        answer = diagnosis(("backlash",), probability)
        answer["candidates"] = answer["candidates"][:1]
        case = marked(("creep",), answer, "withheld", rivals={"backlash": excess})
        assert case.stands_in is stands_in
        assert case.right is False


def test_of_two_at_once_both_must_be_named() -> None:
    pair = ("creep", "backlash")
    assert marked(pair, diagnosis(("backlash", "creep")), "pairs").right is True
    half = marked(pair, diagnosis(("creep",)), "pairs")
    assert (half.right, half.first) == (False, True)


def test_no_answer_is_a_wrong_one() -> None:
    case = marked(("creep",), None)
    assert (case.said, case.right, case.stage_right) == (NO_ANSWER, False, False)
    assert "no answer within 300 s" in reason(case)


@pytest.mark.parametrize(
    ("own", "other", "why"),
    [
        (20e-9, 10e-9, "the named effect's candidate comes nearer to the rig's law"),
        (10e-9, 20e-9, "the cause's own candidate leaves no more"),
    ],
)
def test_why_another_effect_was_named(own: float, other: float, why: str) -> None:
    answer = diagnosis(("backlash", "creep"))
    for entry in answer["candidates"]:
        entry["heldout_rmse_m"] = own if entry["effect"] == "creep" else other
    assert reason(marked(("creep",), answer)).startswith(why)


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("creep", "something was fitted to chance"),
        ("unknown", "what a refit leaves was taken for a cause that the library has not"),
        ("parameters", "nominal and refitted model predict about as well"),
    ],
)
def test_why_a_blank_was_told_wrong(said: str, why: str) -> None:
    assert reason(marked(("none",), diagnosis((said,)))) == why


def test_blanks_are_alarmed_by_effects_and_by_unknown() -> None:
    for said, alarmed in (("none", False), ("parameters", False), ("creep", True)):
        assert marked(("none",), diagnosis((said,))).alarmed is alarmed
    assert marked(("parameters",), diagnosis(("unknown",))).alarmed
    assert marked(("none",), diagnosis(("parameters",))).right is False
