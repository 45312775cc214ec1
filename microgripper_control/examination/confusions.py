"""Which answers were wrong, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from microgripper_control.diagnosis.findings import EFFECTS, NONE, PARAMETERS, UNKNOWN
from microgripper_control.examination.equals import agree
from microgripper_control.examination.marking import NO_ANSWER, Marked
from microgripper_control.examination.plan import PAIRS
from microgripper_control.examination.record import Record


@dataclass(frozen=True)
class Confusion:
    """One wrong answer to one question, how often and in which cases it was given, and why."""

    asked: str
    said: str
    cases: tuple[str, ...]
    reasons: Mapping[str, int]


def confusions(cases: Iterable[Marked]) -> tuple[Confusion, ...]:
    """The most frequent first."""
    wrong: dict[tuple[str, str], list[Marked]] = {}
    for case in cases:
        if case.asked is not None and not case.right:
            wrong.setdefault((case.asked, case.said), []).append(case)
    found = [
        Confusion(
            asked,
            said,
            tuple(case.record.planned.name for case in same),
            dict(Counter(reason(case) for case in same)),
        )
        for (asked, said), same in wrong.items()
    ]
    return tuple(sorted(found, key=lambda one: (-len(one.cases), one.asked, one.said)))


def reason(case: Marked) -> str:
    """Why an answer is wrong, as far as the numbers of the case tell."""
    record = case.record
    if case.said == NO_ANSWER or case.diagnosis is None:
        return f"{record.outcome}: {record.why}"
    if case.asked in (NONE, PARAMETERS):
        return _of_a_blank(case)
    if case.asked == UNKNOWN:
        return _of_a_foreign(case)
    if case.said in (NONE, PARAMETERS):
        return "the gap was taken for chance or for mistuned parameters"
    if case.sealed.question == PAIRS:
        return "one of the two was not named" if case.first else "neither stands first"
    if case.first:
        return "named as ambiguous with an effect whose oracle differs"
    return _of_an_effect(case, case.diagnosis)


def _of_a_blank(case: Marked) -> str:
    if case.said in (NONE, PARAMETERS):
        return "nominal and refitted model predict about as well"
    if case.said == UNKNOWN:
        return "what a refit leaves was taken for a cause that the library has not"
    return "something was fitted to chance"


def _of_a_foreign(case: Marked) -> str:
    if case.said in (NONE, PARAMETERS):
        return "the gap was taken for chance or for mistuned parameters"
    if agree(case.record.rivals.get(case.said)):
        return "the law of the named effect does as well as the true one on these recordings"
    return "the named effect's candidate bends far enough to pass for the true law"


def _of_an_effect(case: Marked, diagnosis: Mapping[str, Any]) -> str:
    own, other = _left(diagnosis, case.asked), _left(diagnosis, case.said)
    if case.said == UNKNOWN:
        return f"the library's candidate left too much of the rig's form {case.sealed.form}"
    if agree(case.record.rivals.get(case.said)):
        return "the oracles of both agree within the noise, and the two were not named together"
    if own is None:
        return "the candidate of the cause could not be fitted"
    if diagnosis["verdict"] == EFFECTS and other is not None and other < own:
        return "the named effect's candidate comes nearer to the rig's law than the cause's own"
    return "the cause's own candidate leaves no more, but was held less probable"


def _left(diagnosis: Mapping[str, Any], name: str | None) -> float | None:
    for entry in diagnosis["candidates"]:
        if entry["effect"] == name:
            left = entry["heldout_rmse_m"]
            return None if left is None else float(left)
    return None


def failures(records: Iterable[Record]) -> tuple[tuple[str, str, str], ...]:
    """Name, outcome and why of each case without an answer."""
    return tuple((r.planned.name, r.outcome, r.why) for r in records if r.diagnosis is None)
