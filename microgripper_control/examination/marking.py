"""Marks one answer against the truth.

Where the diagnosis names the cause as ambiguous with others, the answer is right only if the
oracles of all of them agree within the noise; then any of them may stand first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from microgripper_control.diagnosis.findings import EFFECTS, UNKNOWN
from microgripper_control.examination.asking import ANSWERED
from microgripper_control.examination.equals import agree, groups_with
from microgripper_control.examination.plan import BLIND, PAIRS
from microgripper_control.examination.record import Record
from microgripper_control.examination.sealed import Sealed

NO_ANSWER = "no answer"
WIDE = 2.0  # gap over noise from which a cause outside the library must be called unknown
HALF = 0.5  # a stand-in must be less probable than this


@dataclass(frozen=True)
class Marked:
    """One case, marked; None stands for what cannot be asked.

    `asked` and `said` are an effect or a verdict ("a + b" for two). `first` tells whether the name
    that stands first is right, groups aside.
    """

    record: Record
    sealed: Sealed
    asked: str | None
    said: str
    first: bool | None
    right: bool | None
    stage_right: bool | None

    @property
    def diagnosis(self) -> Mapping[str, Any] | None:
        """What was answered."""
        return self.record.diagnosis

    @property
    def blank(self) -> bool:
        """Whether the rig has no effect at all."""
        return self.sealed.question == BLIND and not self.sealed.causes

    @property
    def alarmed(self) -> bool | None:
        """Whether effects, or an unknown cause, are claimed; None where there is no answer."""
        if self.diagnosis is None:
            return None
        return self.diagnosis["verdict"] in (EFFECTS, UNKNOWN)

    @property
    def further(self) -> bool:
        """Whether effects are named that are not at work."""
        if self.diagnosis is None:
            return False
        return not set(self.diagnosis["effects"]) <= set(self.sealed.effects)

    @property
    def keeps_quiet(self) -> bool:
        """Whether nothing is claimed but what is at work: of effects that cannot be seen."""
        return self.diagnosis is not None and self.said != UNKNOWN and not self.further

    @property
    def foreign(self) -> bool:
        """Whether the cause is not in the library that was asked."""
        return self.sealed.question not in (BLIND, PAIRS)

    @property
    def plainly_unknown(self) -> bool:
        """Whether a cause outside the library is plain to see."""
        return self.asked == UNKNOWN

    @property
    def stands_in(self) -> bool:
        """Whether an effect is named, not surely, whose law does as well as the withheld one's."""
        if self.diagnosis is None or len(self.diagnosis["effects"]) != 1:
            return False
        return agree(self.record.rivals.get(self.said)) and probability_of(self.diagnosis) < HALF

    @property
    def groups(self) -> list[bool | None]:
        """Of each group that the cause is in: whether the oracles of all its members agree.

        None where members were not asked, and those that were agree.
        """
        if self.diagnosis is None or len(self.sealed.seen) != 1:
            return []
        groups = groups_with(self.diagnosis, self.sealed.seen[0].effect)
        return [self._agrees(group) for group in groups]

    def _agrees(self, group: Sequence[str]) -> bool | None:
        rivals = self.record.rivals
        if not all(agree(rivals[name]) for name in group if name in rivals):
            return False
        return True if rivals.keys() >= set(group) else None


def probability_of(diagnosis: Mapping[str, Any]) -> float:
    """Of the most probable entry."""
    return float(max(entry["probability"] for entry in diagnosis["candidates"]))


def mark(record: Record, truth: Mapping[str, Any]) -> Marked:
    """Open a seal and mark the answer; a case without an answer is wrong."""
    sealed = Sealed.of(truth)
    asked, said = _asked(sealed), _said(record)
    if asked is None:
        return Marked(record, sealed, None, said, None, None, None)
    if asked == UNKNOWN:
        right = said == UNKNOWN
        return Marked(record, sealed, asked, said, right, right, _stage_right(record, sealed))
    if sealed.question == PAIRS:
        named = set(record.diagnosis["effects"]) if record.diagnosis else set()
        both = {cause.effect for cause in sealed.seen} <= named
        first = said in asked.split(" + ")
        return Marked(record, sealed, asked, said, first, both, None)
    first = said == asked
    marked = Marked(record, sealed, asked, said, first, first, None)
    if not sealed.seen:
        return marked
    right = _right_with_groups(marked)
    stage = right or _stage_right(record, sealed)
    return Marked(record, sealed, asked, said, first, right, stage)


def _asked(sealed: Sealed) -> str | None:
    if sealed.question == PAIRS:
        pair = [cause.effect for cause in sealed.seen]
        return " + ".join(pair) if len(pair) == 2 else None
    if sealed.causes and not sealed.seen:
        return None
    if sealed.question != BLIND:
        return UNKNOWN if sealed.gap > WIDE else None
    return sealed.seen[0].effect if sealed.seen else sealed.verdict


def _said(record: Record) -> str:
    if record.outcome != ANSWERED or record.diagnosis is None:
        return NO_ANSWER
    effects = record.diagnosis["effects"]
    return str(effects[0] if effects else record.diagnosis["verdict"])


def _right_with_groups(marked: Marked) -> bool:
    if False in marked.groups or marked.diagnosis is None:
        return False
    cause = marked.sealed.seen[0].effect
    return bool(marked.first) or any(
        marked.said in group for group in groups_with(marked.diagnosis, cause)
    )


def _stage_right(record: Record, sealed: Sealed) -> bool:
    """Whether the most probable stage is the cause's, where effects or a cause are claimed."""
    if record.diagnosis is None or record.diagnosis["verdict"] not in (EFFECTS, UNKNOWN):
        return False
    stages: Mapping[str, float] = record.diagnosis["stages"]
    return max(stages, key=lambda stage: stages[stage]) == sealed.seen[0].stage
