"""The whole score of an examination."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from microgripper_control.examination.calibration import (
    CLAIMED,
    Reliability,
    answers,
    presences,
    reliability,
)
from microgripper_control.examination.confusions import Confusion, confusions, failures
from microgripper_control.examination.folder import Folder
from microgripper_control.examination.marking import Marked, mark
from microgripper_control.examination.others import Method, methods
from microgripper_control.examination.places import Places, places
from microgripper_control.examination.plan import (
    BLIND,
    FORMS,
    NEVER,
    PAIRS,
    STRENGTHS,
    WITHHELD,
)
from microgripper_control.examination.record import Record
from microgripper_control.examination.shares import Middle, Share
from microgripper_control.examination.shrinking import DIAGNOSIS, closable, errors_of, over_noise
from microgripper_control.validation.effects.registry import in_library


@dataclass(frozen=True)
class Effect:
    """How often an effect was named, by the strength it had, and its stage found."""

    name: str
    top: Mapping[str, Share]
    stage: Share
    places: Places


@dataclass(frozen=True)
class Matrix:
    """How often what was answered (columns) to what was asked (rows)."""

    asked: tuple[str, ...]
    said: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Foreign:
    """Of causes that the library did not have, where the gap is above twice the noise."""

    unknown: Share
    stands_in: Share  # an effect as good as the true one on these recordings, not surely
    stage: Share
    places: Places
    free_form: Middle  # share that the free-form model closes


@dataclass(frozen=True)
class Score:
    """Everything that is reported; `cases` in the order of the plan."""

    cases: tuple[Marked, ...]
    top: Mapping[str, Share]  # by strength
    first: Mapping[str, Share]  # the same, groups aside
    forms: Mapping[str, Share]
    stage: Share
    alone: Share  # right, and nothing named besides
    groups: Share  # named with the cause in them and asked about: the oracles agree
    blanks: Mapping[str, Share]  # none and parameters told apart
    false_alarms: Share
    unseen: Share  # effects that cannot be seen: nothing else was claimed
    foreign: Mapping[str, Foreign]
    unknown: Share  # questions 2 and 3 together
    pairs: Share
    pairs_alone: Share  # both named, and nothing besides
    pairs_first: Share
    probability: Reliability
    present: Reliability
    present_claimed: Reliability
    places: Places
    errors: Mapping[str, Middle]  # held out, over the noise
    closed: Middle
    seconds: Middle
    longest: float
    effects: tuple[Effect, ...]
    matrix: Matrix
    confusions: tuple[Confusion, ...]
    failures: tuple[tuple[str, str, str], ...]
    methods: tuple[Method, ...]


def score(folder: Folder, records: Sequence[Record]) -> Score:
    """Open the seals and score; a case that could not be made is listed and not counted."""
    unmade = tuple(r for r in records if not folder.seal(r.planned).exists())
    made = [r for r in records if r not in unmade]
    return scored([mark(record, folder.truth(record.planned)) for record in made], unmade)


def scored(cases: Sequence[Marked], unmade: Sequence[Record] = ()) -> Score:
    """Score marked cases."""
    blind = [case for case in cases if case.sealed.question == BLIND]
    seen = [case for case in blind if case.sealed.seen]
    pairs = [case for case in cases if case.sealed.question == PAIRS and case.asked]
    blanks = [case for case in blind if case.blank]
    hidden = [case for case in blind if case.sealed.causes and not case.sealed.seen]
    strength = {name: [c for c in seen if c.sealed.strength == name] for name in STRENGTHS}
    gaps = closable(cases)
    times = [case.record.seconds["diagnosing_busy"] for case in cases]
    return Score(
        cases=tuple(cases),
        top={name: _right(own) for name, own in strength.items()},
        first={name: Share.among(c.first for c in own) for name, own in strength.items()},
        forms={name: _right([c for c in seen if c.sealed.form == name]) for name in FORMS},
        stage=Share.among(case.stage_right for case in seen),
        alone=_alone(seen),
        groups=Share.among(right for case in seen for right in case.groups),
        blanks={
            verdict: _right([case for case in blanks if case.asked == verdict])
            for verdict in ("none", "parameters")
        },
        false_alarms=Share.among(case.alarmed for case in blanks),
        unseen=Share.among(case.keeps_quiet for case in hidden),
        foreign={
            question: _foreign([c for c in cases if c.sealed.question == question])
            for question in (WITHHELD, NEVER)
        },
        unknown=_right([case for case in cases if case.plainly_unknown]),
        pairs=_right(pairs),
        pairs_alone=_alone(pairs),
        pairs_first=Share.among(case.first for case in pairs),
        probability=reliability(answers(cases)),
        present=reliability(presences(cases)),
        present_claimed=reliability(presences(cases, CLAIMED)),
        places=places([*seen, *pairs]),
        errors=over_noise(gaps),
        closed=Middle.among([errors.closed[DIAGNOSIS] for errors in gaps]),
        seconds=Middle.among(times),
        longest=max(times, default=float("nan")),
        effects=tuple(_effect(name, seen) for name in in_library(True)),
        matrix=matrix(cases),
        confusions=confusions(cases),
        failures=failures([*unmade, *(case.record for case in cases)]),
        methods=methods(cases),
    )


def _right(cases: Sequence[Marked]) -> Share:
    return Share.among(case.right for case in cases)


def _alone(cases: Sequence[Marked]) -> Share:
    """Right, and nothing named besides."""
    return Share.among(bool(case.right) and not case.further for case in cases)


def _effect(name: str, seen: Sequence[Marked]) -> Effect:
    own = [case for case in seen if case.asked == name]
    return Effect(
        name,
        {s: _right([case for case in own if case.sealed.strength == s]) for s in STRENGTHS},
        Share.among(case.stage_right for case in own),
        places(own),
    )


def _foreign(cases: Sequence[Marked]) -> Foreign:
    plain = [case for case in cases if case.plainly_unknown]
    closed = [errors_of(case).free_form for case in plain]
    return Foreign(
        unknown=_right(plain),
        stands_in=Share.among(case.stands_in for case in plain),
        stage=Share.among(case.stage_right for case in plain),
        places=places(plain),
        free_form=Middle.among([share for share in closed if share is not None]),
    )


def matrix(cases: Sequence[Marked]) -> Matrix:
    """Of single causes and blanks; those that the library did not have are rows of their own."""
    rows = (*in_library(True), "none", "parameters", WITHHELD, NEVER)
    columns = (*in_library(True), "none", "parameters", "unknown", "no answer")
    counts = {row: dict.fromkeys(columns, 0) for row in rows}
    for case in cases:
        if case.asked is None or case.sealed.question == PAIRS:
            continue
        row = case.sealed.question if case.foreign else case.asked
        if case.said in counts[row]:
            counts[row][case.said] += 1
    return Matrix(rows, columns, tuple(tuple(counts[row].values()) for row in rows))
