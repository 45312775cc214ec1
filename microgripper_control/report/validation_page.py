"""The page of an examination: what must hold and whether it does, and all that is behind it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from microgripper_control.examination.places import Places
from microgripper_control.examination.plan import (
    FIRST_SEED,
    NEVER,
    STRENGTHS,
    WITHHELD,
    Extent,
)
from microgripper_control.examination.score import Score
from microgripper_control.examination.shares import Middle, Share
from microgripper_control.examination.targets import MET, MISSED, Target, targets
from microgripper_control.report.page import Page
from microgripper_control.report.validation_figures import (
    draw_effects,
    draw_errors,
    draw_matrix,
    draw_reliability,
)
from microgripper_control.report.wording import ABSENT, percent, plain
from microgripper_control.validation.case import DEVELOPMENT_SEEDS

TARGET_HEADER = ("demand", "found", "95 % interval", "cases", "wanted", "")
TARGET_TEXTS = (0, 5)

INTRODUCTION = (
    "The diagnosis was asked about rigs that it has never seen, made by a generator that shares no "
    "code with it and whose laws differ from its candidates'. It ran as a process of its own that "
    "got recordings and the nominal model, under neutral names. The truth was sealed elsewhere and "
    "opened afterwards."
)


def write_validation_page(score: Score, folder: Path, extent: Extent) -> Path:
    """Write `validation.html` and its figures into a folder; returns the page's path."""
    page = Page("The diagnosis, examined")
    page.paragraph(INTRODUCTION)
    page.paragraph(_extent(score, extent))
    page.heading("What must hold")
    page.paragraph(_plainly(targets(score)))
    page.table(TARGET_HEADER, target_rows(score), TARGET_TEXTS)
    page.note(
        "A calibration error above what is wanted is held against the diagnosis only if it is also "
        "above what chance makes of so few cases: a calibrated one would show it, too."
    )
    if score.cases:
        _named(page, score, folder)
        _foreign(page, score)
        _probabilities(page, score, folder)
        _gap(page, score, folder)
        _where(page, score)
    _wrong(page, score)
    path = folder / "validation.html"
    page.write(path)
    return path


def target_rows(score: Score) -> list[tuple[str, ...]]:
    """The demands as the page and the command show them."""
    return [_target(target) for target in targets(score)]


def _target(target: Target) -> tuple[str, ...]:
    sign = "≤" if target.at_most else "≥"
    if math.isnan(target.low) and target.name.startswith("calibration"):
        found = ABSENT if math.isnan(target.value) else f"{target.value:.3f}"
        return target.text, found, "", str(target.of), f"{sign} {target.limit:g}", target.verdict
    known = math.isfinite(target.low)  # not of none, nor of a median of a few
    interval = f"{percent(target.low)} to {percent(target.high)}" if known else ""
    wanted = f"{sign} {percent(target.limit)}"
    found = percent(target.value, 1)
    return target.text, found, interval, str(target.of), wanted, target.verdict


def _plainly(demands: Sequence[Target]) -> str:
    """The outcome in words."""
    missed = [target.text for target in demands if target.verdict == MISSED]
    met = sum(target.verdict == MET for target in demands)
    rest = len(demands) - met - len(missed)
    parts = [f"{met} of {len(demands)} demands are met."]
    if missed:
        parts.append(f"Not met: {'; '.join(missed)}.")
    if rest:
        parts.append(f"For {rest} there are too few cases to tell.")
    return " ".join(parts)


def _extent(score: Score, extent: Extent) -> str:
    kind = "a quick examination" if extent.quick else "the full examination"
    if extent.only is not None:
        kind = f"the {extent.only.value} of {kind}"
    if extent.first is not None:
        kind = f"the first {extent.first} of {kind}, in which they are shuffled,"
    seeds = [case.record.planned.seed for case in score.cases]
    used = f"{min(seeds)} to {max(seeds)}" if seeds else "none"
    return (
        f"{len(score.cases)} cases, {kind} with seed {extent.seed}; repeat it with "
        f"{extent.command}. The cases' own seeds are {used}; they begin "
        f"at {FIRST_SEED}. The method was developed and calibrated on seeds "
        f"{DEVELOPMENT_SEEDS[0]} to {DEVELOPMENT_SEEDS[-1]}, which give one of each effect's two "
        "laws alone: form a. Form b appears in examinations only."
        + (f" Mind that {extent.caution}." if extent.caution else "")
    )


def _named(page: Page, score: Score, folder: Path) -> None:
    page.heading("Blind: is the effect named?")
    page.paragraph(
        "Strengths are what the effect does: the error without it over the noise is about 1.5 "
        "(weak), 5 (medium), 30 (strong); where a recording shows less than was asked for, it "
        "counts as what it shows. Where the diagnosis names a group as ambiguous, the answer is "
        "right only if the rig's own laws of all its members agree within the noise."
    )
    rows = [_row(f"named, {name}", score.top[name]) for name in STRENGTHS]
    rows += [_row(f"named first, groups aside, {name}", score.first[name]) for name in STRENGTHS]
    rows += [_row(f"named, form {name} of the law", share) for name, share in score.forms.items()]
    rows += [
        _row("stage found", score.stage),
        _row("right, and nothing named besides", score.alone),
        _row("groups named whose oracles agree", score.groups),
        _row("two at once: both named", score.pairs),
        _row("two at once: both, and nothing besides", score.pairs_alone),
        _row("two at once: one of them first", score.pairs_first),
        _row("nothing wrong: “none” said", score.blanks["none"]),
        _row("mistuned only: “parameters” said", score.blanks["parameters"]),
        _row("false alarms on the two", score.false_alarms),
        _row("effects that cannot be seen: nothing else claimed", score.unseen),
    ]
    page.table(("", "share", "95 % interval", "cases"), rows)
    png = folder / "effects.png"
    draw_effects(score, png)
    page.figure(png, "How often each effect was named, by strength.")
    png = folder / "matrix.png"
    draw_matrix(score, png)
    page.figure(
        png,
        "What was answered (columns) to what was true (rows). In the rows “withheld” and “never” "
        "the library did not have the cause: unknown is right there.",
    )


def _foreign(page: Page, score: Score) -> None:
    page.heading("Causes that the library does not have")
    page.paragraph(
        "In “withheld” the candidate of the effect at work was taken out of the library, in "
        "“never” there is none. Counted where the gap is above twice the noise. A stand-in is "
        "equivalent where its own law does as well as the true one within the noise, and it was "
        "not given as probable."
    )
    header = ("", "unknown said", "equivalent stand-in", "stage", "where found", "free-form closes")
    rows = []
    for question in (WITHHELD, NEVER):
        found = score.foreign[question]
        shares = (found.unknown, found.stands_in, found.stage, found.places.recall)
        middle = _middle(found.free_form)
        rows.append((f"{question} ({found.unknown.of})", *map(_share, shares), middle))
    page.table(header, rows)


def _probabilities(page: Page, score: Score, folder: Path) -> None:
    page.heading("Are its probabilities to be believed?")
    png = folder / "reliability.png"
    draw_reliability(score, png)
    page.figure(
        png,
        "Left: the most probable answer of each case. Right: each effect in each case. The numbers "
        "are how many there are; a calibrated diagnosis lies on the dashed line, but for chance: "
        "of few cases it shows an error, too, as large as the first table says.",
    )
    page.note(
        f"Expected calibration error of “present” where it is at least 0.05: "
        f"{_plain(score.present_claimed.error)} ({score.present_claimed.of} claims). Of the two, "
        "the larger is held against the demand, unless the other alone is more than chance makes."
    )


def _gap(page: Page, score: Score, folder: Path) -> None:
    page.heading("How far the gap shrinks, and what one would do instead")
    page.paragraph(
        "On the same recordings and the same held-out samples: refitting every candidate (from one "
        "first guess, with the library's prior and plausible ranges) and taking the smallest BIC; "
        "sparse regression of what the refit leaves (sequentially thresholded least squares, as in "
        "pysindy) on terms that each stand for an effect; a Gaussian process on the past of the "
        "voltage, which names nothing. "
        "Effects count as named where they stand first, all strengths together, groups aside."
    )
    header = (
        "",
        "effect named",
        "stage",
        "false alarms",
        "unknown said",
        "gap closed (median)",
        "time (median)",
    )
    rows = [
        (
            method.name,
            _share(method.top),
            _share(method.stage),
            _share(method.false_alarms),
            _share(method.unknown),
            _middle(method.closed),
            ABSENT if not method.seconds.of else f"{method.seconds.value:.0f} s",
        )
        for method in score.methods
    ]
    page.table(header, rows)
    steps = [
        (name, f"{middle.value:.2f}" if middle.of else ABSENT, str(middle.of))
        for name, middle in score.errors.items()
    ]
    page.table(("held-out error", "median, over the noise", "cases"), steps)
    png = folder / "errors.png"
    draw_errors(score, png)
    page.figure(
        png,
        "Left: held-out errors over the sensor's noise, as shares of the cases whose effect the "
        "library has. Right: what part each method closes of what the oracle, the rig's own law, "
        "closes.",
    )
    if score.seconds.of:
        page.note(
            f"A diagnosis took {score.seconds.value:.0f} s (median) and {score.longest:.0f} s at "
            "most, on one core."
        )


def _where(page: Page, score: Score) -> None:
    page.heading("Does it point to the right place?")
    page.paragraph(
        "Ranges reported against the rig's own: the same axis, half of the shorter range in "
        "common, and no longer than twice the rig's own or a fifth of how far from zero that "
        "reaches. Ranges on axes of which the truth says nothing are "
        "counted apart; without an answer none is reported."
    )
    rows = [_places("all", score.places)]
    rows += [
        _places(plain(effect.name), effect.places)
        for effect in score.effects
        if effect.places.recall.of
    ]
    page.table(("", "reported are right", "true are reported", "on other axes"), rows)


def _wrong(page: Page, score: Score) -> None:
    page.heading("What it got wrong, and why")
    if not score.confusions:
        page.paragraph("Nothing.")
    rows = [
        (plain(one.asked), plain(one.said), reason, str(count), ", ".join(one.cases))
        for one in score.confusions
        for reason, count in one.reasons.items()
    ]
    if rows:
        page.table(("true", "answered", "reason", "times", "cases"), rows, (0, 1, 2, 4))
    if score.failures:
        page.caption("Cases without an answer")
        page.table(("case", "outcome", "why"), score.failures, (0, 1, 2))


def _row(text: str, share: Share) -> tuple[str, str, str, str]:
    if not share.of:
        return text, ABSENT, "", "0"
    low, high = share.interval
    return text, percent(share.value), f"{percent(low)} to {percent(high)}", str(share.of)


def _places(text: str, found: Places) -> tuple[str, str, str, str]:
    return text, _share(found.precision), _share(found.recall), str(found.elsewhere)


def _share(share: Share) -> str:
    return f"{percent(share.value)} of {share.of}" if share.of else ABSENT


def _middle(middle: Middle) -> str:
    return percent(middle.value) if middle.of else ABSENT


def _plain(value: float) -> str:
    return ABSENT if math.isnan(value) else f"{value:.3f}"
