"""Whether `where` points to where the rig's effect truly shows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from microgripper_control.examination.marking import Marked
from microgripper_control.examination.sealed import Span
from microgripper_control.examination.shares import Share

OVERLAP = 0.5  # of the shorter of two ranges that are the same place
LONGEST = 2.0  # of a claimed range, in true ones
WIDEST = 0.2  # the same, of how far from zero the true one reaches: a hum has 1 Hz and looks wider


@dataclass(frozen=True)
class Places:
    """Of some cases: reported ranges that are right, and true ones that are reported.

    `precision` is of the ranges on axes on which the truth has a place; the truth is silent on the
    others, and `elsewhere` counts the ranges there. A case without an answer has found no place.
    """

    precision: Share
    recall: Share
    elsewhere: int


def same(claimed: Span, true: Span) -> bool:
    """Whether a claimed range tells where the true one is: they share half of the shorter.

    It must be on the same axis, and no longer than twice the true one or than a fifth of how far
    from zero that reaches.
    """
    if claimed.axis != true.axis:
        return False
    shared = min(claimed.high, true.high) - max(claimed.low, true.low)
    length, wanted = claimed.high - claimed.low, true.high - true.low
    longest = max(LONGEST * wanted, WIDEST * max(abs(true.low), abs(true.high)))
    return length <= longest and shared >= OVERLAP * min(length, wanted)


def places(cases: Iterable[Marked]) -> Places:
    """Of the cases whose effects show somewhere in particular."""
    right = reported = found = true = elsewhere = 0
    for case in cases:
        spans = [span for cause in case.sealed.seen for span in cause.where]
        if not spans:
            continue
        where = case.diagnosis["where"] if case.diagnosis is not None else []
        said = [Span(r["axis"], r["low"], r["high"]) for r in where]
        axes = {span.axis for span in spans}
        on_axes = [one for one in said if one.axis in axes]
        elsewhere += len(said) - len(on_axes)
        right += sum(any(same(one, span) for span in spans) for one in on_axes)
        reported += len(on_axes)
        found += sum(any(same(one, span) for one in on_axes) for span in spans)
        true += len(spans)
    return Places(Share(right, reported), Share(found, true), elsewhere)
