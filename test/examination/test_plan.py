"""Plans are decided by the seed, ask all that is to be asked, and use no seed of development."""

from __future__ import annotations

from collections import Counter

import pytest

from microgripper_control.examination.plan import FIRST_SEED, Extent, Part, Planned, plan
from microgripper_control.validation.case import DEVELOPMENT_SEEDS, REPORTING_SEEDS
from microgripper_control.validation.effects.registry import in_library
from microgripper_control.validation.excitation import suited


@pytest.mark.parametrize("quick", [True, False])
def test_the_seed_decides_the_plan(quick: bool) -> None:
    assert plan(3, quick) == plan(3, quick)
    assert plan(3, quick) != plan(4, quick)


@pytest.mark.parametrize("quick", [True, False])
def test_no_two_cases_share_a_seed_and_none_is_of_the_development(quick: bool) -> None:
    seeds = [case.seed for seed in (0, 1, 2) for case in plan(seed, quick)]
    assert len(set(seeds)) == len(seeds)
    assert min(seeds) > FIRST_SEED > DEVELOPMENT_SEEDS[-1]
    assert all(seed in REPORTING_SEEDS for seed in seeds)


def test_a_full_plan_asks_everything() -> None:
    cases = plan(1, quick=False)
    blind = [case for case in cases if case.question == "blind"]
    usual = Counter((c.effects[0], c.form, c.strength) for c in blind if c.excitation != "poor")
    for effect in in_library(True):
        for form in ("a", "b"):
            for strength in ("weak", "medium", "strong"):
                assert usual[effect, form, strength] == 2
    assert {c.effects[0] for c in blind if c.excitation == "poor"} == set(in_library(True))
    assert sum(case.effects[0] in ("none", "parameters") for case in blind) >= 150
    for question, library in (("withheld", True), ("never", False)):
        asked = {case.effects[0] for case in cases if case.question == question}
        assert asked == set(in_library(library))
    pairs = [case.effects for case in cases if case.question == "pairs"]
    assert len(pairs) == 24
    assert all(len(set(pair)) == 2 for pair in pairs)


def test_its_parts_are_the_whole_plan_and_each_may_be_asked_by_itself() -> None:
    cases = plan(1, quick=False)
    counts = {part: len(Extent(1, only=part).of(cases)) for part in Part}
    assert counts == {"effects": 221, "blanks": 150, "withheld": 68, "never": 52, "pairs": 24}
    assert sum(counts.values()) == len(Extent(1).of(cases)) == len(cases)
    some = Extent(1, only=Part.BLANKS, first=5)
    assert some.of(cases) == [c for c in cases if c.effects[0] in ("none", "parameters")][:5]
    assert some.command == "microgripper validate --seed 1 --only blanks --first 5 --out DIR"


def test_a_quick_plan_asks_each_effect_once() -> None:
    cases = plan(1, quick=True)
    assert len(cases) == 40
    named = Counter(case.effects[0] for case in cases if case.question == "blind")
    assert all(named[effect] == 1 for effect in in_library(True))
    assert named["none"] == named["parameters"] == 4
    asked = [(c.form, c.strength) for c in cases if c.effects[0] in in_library(True)]
    assert len(set(asked)) == 6
    assert {case.question for case in cases} == {"blind", "withheld", "never", "pairs"}
    assert all(case.brief for case in cases)
    assert not any(case.brief for case in plan(1, quick=False))


def test_effects_are_asked_for_on_recordings_that_can_show_them() -> None:
    for case in plan(1, quick=False):
        if case.excitation != "poor" and case.effects[0] not in ("none", "parameters"):
            assert all(case.excitation in suited(effect) for effect in case.effects)


def test_neither_the_name_nor_the_number_of_a_case_tells_its_effect() -> None:
    first, second = plan(1, quick=True), plan(2, quick=True)
    assert [case.name for case in first] == [case.name for case in second]
    assert [case.effects for case in first] != [case.effects for case in second]


def test_a_case_survives_being_written() -> None:
    case = plan(1, quick=True)[0]
    assert Planned.of(case.plain()) == case


def test_only_the_withheld_question_takes_effects_out_of_the_library() -> None:
    for case in plan(1, quick=True):
        assert case.withheld == (case.effects if case.question == "withheld" else ())
