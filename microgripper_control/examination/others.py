"""The other methods, marked on the same cases by the same rules."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from microgripper_control.diagnosis.findings import EFFECTS, UNKNOWN
from microgripper_control.examination.beside.compare import METHODS
from microgripper_control.examination.marking import Marked
from microgripper_control.examination.plan import BLIND
from microgripper_control.examination.shares import Middle, Share
from microgripper_control.examination.shrinking import DIAGNOSIS, closable


@dataclass(frozen=True)
class Method:
    """How one method did; its first name counts, groups aside."""

    name: str
    top: Share
    stage: Share
    false_alarms: Share
    unknown: Share
    closed: Middle
    seconds: Middle


def methods(cases: Sequence[Marked]) -> tuple[Method, ...]:
    """The diagnosis and, beside it, the others."""
    return (_method(DIAGNOSIS, cases, _own), *(_other(name, cases) for name in METHODS))


Said = tuple[str | None, str | None, float | None]  # answer (None: there is none), stage, s


def _own(case: Marked) -> Said:
    stage = None
    if case.diagnosis is not None and case.diagnosis["verdict"] in (EFFECTS, UNKNOWN):
        stages = case.diagnosis["stages"]
        stage = max(stages, key=lambda name: stages[name])
    said = None if case.diagnosis is None else case.said
    return said, stage, case.record.seconds.get("diagnosing_busy")


def _other(name: str, cases: Sequence[Marked]) -> Method:
    def said(case: Marked) -> Said:
        beside = case.record.beside.get(name)
        return (beside.answer, beside.stage, beside.seconds) if beside else (None, None, None)

    return _method(name, cases, said)


def _method(name: str, cases: Sequence[Marked], said: Callable[[Marked], Said]) -> Method:
    blind = [case for case in cases if case.sealed.question == BLIND and case.sealed.seen]
    blanks = [case for case in cases if case.blank]
    foreign = [case for case in cases if case.plainly_unknown]
    names = any(said(case)[0] is not None for case in cases)
    shown = (lambda found: found) if names else (lambda found: [])
    return Method(
        name=name,
        top=Share.among(shown([said(case)[0] == case.asked for case in blind])),
        stage=Share.among(shown([said(c)[1] == c.sealed.seen[0].stage for c in blind])),
        false_alarms=Share.among(shown([_claims(said(case)) for case in blanks])),
        unknown=Share.among(shown([said(case)[0] == UNKNOWN for case in foreign])),
        closed=Middle.among([e.closed[name] for e in closable(cases) if name in e.closed]),
        seconds=Middle.among([s for case in cases if (s := said(case)[2]) is not None]),
    )


def _claims(said: Said) -> bool | None:
    """Whether an effect, or an unknown cause, is claimed; None where there is no answer."""
    answer, stage, _ = said
    return None if answer is None else stage is not None or answer == UNKNOWN
