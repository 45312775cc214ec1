"""Each share of a score in which no two are of the same cases, and where it is shown."""

from __future__ import annotations

import re
from dataclasses import replace
from html import unescape
from pathlib import Path

import pytest
from hand_made import CONTACT, diagnosis, marked

from microgripper_control.examination.marking import Marked
from microgripper_control.examination.plan import Extent
from microgripper_control.examination.score import Score, scored
from microgripper_control.examination.sealed import Span
from microgripper_control.examination.shares import Share
from microgripper_control.examination.targets import targets
from microgripper_control.report.validation_page import write_validation_page

LAG, LAGS = ("amplifier_lag",), (("amplifier_lag", "sensor_lag"),)
LOW, VOLTAGE = Span("displacement_m", 0.0, 1e-6), Span("voltage_V", 80.0, 160.0)
SAME, OTHER = {"sensor_lag": 0.1}, {"sensor_lag": 9.0}
PLACE, NEAR = (CONTACT,), {"backlash": 0.1}


def of_the_library() -> list[Marked]:
    """18 effects that are seen: 10 medium, 5 strong, 3 weak, which are of law b."""
    found = diagnosis(("contact",), where=PLACE)
    beside = diagnosis(("contact",), where=(CONTACT, LOW))
    weak = [
        *[marked(("creep",), diagnosis(("creep",)), ratio=1.5)] * 2,
        marked(("creep",), diagnosis(("backlash",)), ratio=1.5),
    ]
    return [
        *[marked(("contact",), found, where=PLACE)] * 4,
        marked(("contact",), beside, where=PLACE),
        *[marked(("contact",), None, where=PLACE)] * 2,
        *[marked(LAG, diagnosis(LAG, groups=LAGS), rivals=SAME)] * 2,
        marked(LAG, diagnosis(LAG, groups=LAGS), rivals=OTHER),
        marked(LAG, diagnosis(("sensor_lag",), groups=LAGS), rivals=SAME, ratio=30.0),
        marked(("creep",), diagnosis(("creep", "backlash")), ratio=30.0),
        *[marked(("creep",), diagnosis(("rate_dependent_hysteresis",)), ratio=30.0)] * 3,
        *[replace(one, sealed=replace(one.sealed, form="b")) for one in weak],
    ]


def without_an_effect() -> list[Marked]:
    """9 blanks, of which one has no answer, and 5 effects that cannot be seen."""
    return [
        *[marked(("none",), diagnosis(("none",)))] * 3,
        marked(("none",), diagnosis(("creep",))),
        *[marked(("parameters",), diagnosis(("parameters",)))] * 2,
        *[marked(("parameters",), diagnosis(("unknown",)))] * 2,
        marked(("parameters",), None),
        *[marked(("creep",), diagnosis(("parameters",)), seen=False)] * 4,
        marked(("creep",), diagnosis(("contact",), groups=LAGS), seen=False),
    ]


def of_no_library() -> list[Marked]:
    """6 withheld causes and one that is not plain to see, and 4 that were never there."""
    stand_in = diagnosis(("backlash",), 0.4)
    stand_in["candidates"] = stand_in["candidates"][:1]
    grouped = diagnosis(("contact", "creep"), groups=(("contact", "creep"),))
    return [
        marked(("creep",), diagnosis(("unknown",), where=PLACE), "withheld", where=PLACE),
        marked(("creep",), diagnosis(("unknown",)), "withheld", where=PLACE),
        marked(("creep",), stand_in, "withheld", NEAR),
        marked(("creep",), stand_in, "withheld", NEAR, ratio=2.0),
        *[marked(("creep",), grouped, "withheld", {"contact": 9.0})] * 2,
        marked(("creep",), diagnosis(("rate_dependent_hysteresis",)), "withheld"),
        *[marked(("supply_sag",), diagnosis(("unknown",)), "never")] * 3,
        marked(("supply_sag",), diagnosis(("backlash",)), "never"),
    ]


def of_pairs() -> list[Marked]:
    """Of 6 three are named, one of them with a third; of another one effect."""
    pair = ("creep", "contact")
    both = diagnosis(pair, where=(CONTACT, VOLTAGE))
    return [
        *[marked(pair, both, "pairs", where=PLACE)] * 2,
        marked(pair, diagnosis((*pair, "backlash")), "pairs"),
        marked(pair, diagnosis(("contact",)), "pairs"),
        *[marked(pair, diagnosis(("backlash",)), "pairs")] * 2,
    ]


@pytest.fixture(scope="module")
def score() -> Score:
    return scored([*of_the_library(), *without_an_effect(), *of_no_library(), *of_pairs()])


def test_the_shares_of_the_library(score: Score) -> None:
    assert score.top == {"weak": Share(2, 3), "medium": Share(7, 10), "strong": Share(2, 5)}
    assert score.first == {"weak": Share(2, 3), "medium": Share(8, 10), "strong": Share(1, 5)}
    assert score.forms == {"a": Share(9, 15), "b": Share(2, 3)}
    assert score.stage == Share(15, 18)
    assert score.alone == Share(9, 18)
    assert score.groups == Share(3, 4)


def test_the_shares_without_an_effect(score: Score) -> None:
    assert score.blanks == {"none": Share(3, 4), "parameters": Share(2, 5)}
    assert score.false_alarms == Share(3, 8)
    assert score.unseen == Share(4, 5)


def test_the_shares_of_no_library(score: Score) -> None:
    withheld, never = score.foreign["withheld"], score.foreign["never"]
    assert (withheld.unknown, never.unknown, score.unknown) == (
        Share(2, 6),
        Share(3, 4),
        Share(5, 10),
    )
    assert (withheld.stands_in, never.stands_in) == (Share(1, 6), Share(0, 4))
    assert (withheld.stage, never.stage) == (Share(1, 6), Share(3, 4))
    assert (withheld.places.recall, never.places.recall) == (Share(1, 2), Share(0, 0))
    assert (withheld.free_form.of, never.free_form.of) == (6, 4)


def test_the_shares_of_pairs(score: Score) -> None:
    assert (score.pairs, score.pairs_alone) == (Share(3, 6), Share(2, 6))
    assert score.pairs_first == Share(4, 6)


def test_the_places_are_those_of_effects_of_the_library_alone_and_in_pairs(score: Score) -> None:
    assert (score.places.precision, score.places.recall) == (Share(7, 8), Share(9, 11))
    assert score.places.elsewhere == 2
    contact = {effect.name: effect for effect in score.effects}["contact"]
    assert (contact.places.precision, contact.places.recall) == (Share(5, 6), Share(5, 7))
    assert contact.stage == Share(5, 7)


def test_the_methods_are_asked_for_effect_and_stage(score: Score) -> None:
    own, other, *_ = score.methods  # the other says creep, of the material, whatever is asked
    assert (own.top, own.stage) == (Share(11, 18), Share(14, 18))
    assert (own.false_alarms, own.unknown) == (Share(3, 8), Share(5, 10))
    assert (other.top, other.stage) == (Share(7, 18), Share(7, 18))
    assert (other.false_alarms, other.unknown) == (Share(9, 9), Share(0, 10))


def test_each_demand_holds_its_own_share_against_its_own_limit(score: Score) -> None:
    found = {one.name: (one.value, one.of, one.limit, one.at_most) for one in targets(score)}
    answered = score.probability.of
    assert found == {
        "top_1": (pytest.approx(9 / 15), 15, 0.95, False),
        "top_1_weak": (pytest.approx(2 / 3), 3, 0.80, False),
        "stage": (pytest.approx(15 / 18), 18, 0.97, False),
        "false_alarms": (pytest.approx(3 / 8), 8, 0.02, True),
        "unknown": (pytest.approx(5 / 10), 10, 0.85, False),
        "gap_closed": (score.closed.value, score.closed.of, 0.90, False),
        "calibration_probability": (score.probability.error, answered, 0.07, True),
        "calibration_present": (score.present_claimed.error, answered, 0.07, True),
    }


def test_the_page_shows_each_share_in_its_row(score: Score, tmp_path: Path) -> None:
    page = write_validation_page(score, tmp_path, Extent(1)).read_text(encoding="utf-8")
    rows = {
        text: (share, cases)
        for text, share, cases in re.findall(
            r'<tr><td class="text">([^<]*)</td><td>([^<]*)</td><td>[^<]* to [^<]*</td>'
            r"<td>(\d+)</td></tr>",
            unescape(page),
        )
    }
    shares = {
        "named, weak": Share(2, 3),
        "named, medium": Share(7, 10),
        "named, strong": Share(2, 5),
        "named first, groups aside, weak": Share(2, 3),
        "named first, groups aside, medium": Share(8, 10),
        "named first, groups aside, strong": Share(1, 5),
        "named, form a of the law": Share(9, 15),
        "named, form b of the law": Share(2, 3),
        "stage found": Share(15, 18),
        "right, and nothing named besides": Share(9, 18),
        "groups named whose oracles agree": Share(3, 4),
        "two at once: both named": Share(3, 6),
        "two at once: both, and nothing besides": Share(2, 6),
        "two at once: one of them first": Share(4, 6),
        "nothing wrong: “none” said": Share(3, 4),
        "mistuned only: “parameters” said": Share(2, 5),
        "false alarms on the two": Share(3, 8),
        "effects that cannot be seen: nothing else claimed": Share(4, 5),
    }
    assert rows == {
        text: (f"{100.0 * share.value:.0f}\N{NO-BREAK SPACE}%", str(share.of))
        for text, share in shares.items()
    }
