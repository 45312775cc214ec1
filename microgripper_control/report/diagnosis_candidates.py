"""The candidates of a diagnosis: how probable each is, what was fitted, what speaks for it."""

from __future__ import annotations

from collections.abc import Sequence

from microgripper_control.core.parameters import Parameter
from microgripper_control.diagnosis.findings import Candidate, Diagnosis, Signature
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Setting
from microgripper_control.report.markup import Html, element, joined
from microgripper_control.report.wording import (
    ABSENT,
    ANSWERS,
    listed,
    nanometres,
    percent,
    plain,
    quantity,
    span,
)

PROBABLE, PRESENT = 0.01, 0.05  # from either on a candidate has a row at sight
HEADER = ("candidate", "probability", "at work", "error left", "takes away")
JUDGEMENTS = {True: ("✓", "agrees"), False: ("✗", "contradicts"), None: (ABSENT, "cannot tell")}


def candidates(diagnosis: Diagnosis) -> Html:
    """Every candidate: the likely ones at sight, the others folded."""
    likely = [c for c in diagnosis.candidates if _likely(c, diagnosis)]
    others = [c for c in diagnosis.candidates if not _likely(c, diagnosis)]
    unfitted = sum(c.stage is not None and c.rmse is None for c in others)
    which = "its note" if unfitted == 1 else "their notes"
    remark = f"; {unfitted} not fitted to all samples: see {which}" if unfitted else ""
    folded = element(
        "details",
        element("summary", f"{len(others)} more that are unlikely{remark}"),
        _table(others, diagnosis.effects),
    )
    return element(
        "section",
        element("h2", "Which cause"),
        _table(likely, diagnosis.effects),
        folded if others else None,
        element(
            "p",
            "Probability: that this is the answer, or the largest of several; it sums to one. "
            "At work: that this effect is there at all. Error left: with this candidate alone "
            "added and everything refitted. Takes away: its share of the closable gap.",
            class_="note",
        ),
    )


def _likely(candidate: Candidate, diagnosis: Diagnosis) -> bool:
    at_work = candidate.stage is not None and candidate.present >= PRESENT
    named = candidate.effect in diagnosis.effects
    return named or at_work or candidate.probability >= PROBABLE


def _table(rows: Sequence[Candidate], effects: Sequence[str]) -> Html:
    head = element("tr", *(element("th", name, scope="col") for name in HEADER))
    bodies = (_rows(candidate, candidate.effect in effects) for candidate in rows)
    return element("table", element("thead", head), joined(*bodies), class_="candidates")


def _rows(candidate: Candidate, diagnosed: bool) -> Html:
    """A candidate's numbers, and below them its details."""
    name = ANSWERS.get(candidate.effect, plain(candidate.effect))
    word, _, remark = name.partition(": ")
    place = candidate.stage or remark
    fitted = candidate.rmse is not None
    numbers = element(
        "tr",
        element("th", element("strong", word), element("small", place), scope="row"),
        element("td", _meter(candidate.probability)),
        element("td", percent(candidate.present) if candidate.stage else "", class_="number"),
        element("td", f"{nanometres(candidate.rmse)} nm" if fitted else ABSENT, class_="number"),
        element("td", percent(candidate.share) if candidate.stage else "", class_="number"),
    )
    more = _details(candidate, diagnosed)
    row = element("tr", element("td", more, colspan="5"), class_="more") if more else None
    return element("tbody", numbers, row, class_="diagnosed" if diagnosed else None)


def _meter(probability: float) -> Html:
    share = 100.0 * min(max(probability, 0.0), 1.0)
    bar = element("span", class_="bar", style=f"width:{share:.1f}%")
    return joined(
        element("span", percent(probability), class_="number"),
        element("span", bar, class_="meter", aria_hidden="true"),
    )


def _details(candidate: Candidate, diagnosed: bool) -> Html | None:
    note = element("p", candidate.note) if candidate.note else None
    parts = [note, _parameters(candidate), _signatures(candidate.signatures)]
    if not any(parts):
        return None
    known = [
        "note" if candidate.note else "",
        "parameters" if candidate.parameters else "",
        "signatures" if candidate.signatures else "",
    ]
    summary = listed(tuple(word for word in known if word)).capitalize()
    return element("details", element("summary", summary), *parts, open=diagnosed)


def _parameters(candidate: Candidate) -> Html | None:
    if not candidate.parameters:
        return None
    link = registry().get(candidate.effect)
    values = {name: setting.value for name, setting in candidate.parameters.items()}
    idle = link.idle(values) if link else ()
    rows = [
        _parameter(link.parameter(name) if link else None, name, setting)
        for name, setting in candidate.parameters.items()
        if name not in idle
    ]
    known = any(setting.interval for setting in candidate.parameters.values())
    titles = ("parameter", "value", "95 %" if known else "")
    head = element("tr", *(element("th", title, scope="col") for title in titles))
    body = element("tbody", joined(*rows))
    return element("table", element("thead", head), body, class_="parameters")


def _parameter(declared: Parameter | None, name: str, setting: Setting) -> Html:
    unit = declared.unit if declared else "1"
    interval = span(*setting.interval, unit) if setting.interval else ""
    if declared and not declared.fitted:
        interval = "chosen"
    return element(
        "tr",
        element(
            "th",
            plain(name),
            element("small", declared.description) if declared else None,
            scope="row",
        ),
        element("td", quantity(setting.value, unit, 4), class_="number"),
        element("td", interval, class_="number"),
    )


def _signatures(signatures: Sequence[Signature]) -> Html | None:
    if not signatures:
        return None
    items = []
    for signature in signatures:
        mark, word = JUDGEMENTS[signature.agrees]
        sign = element("span", mark, class_="mark", aria_hidden="true")
        judgement = element("strong", word)
        items.append(element("li", sign, judgement, f": {signature.statement}", class_=word[:3]))
    return element("ul", joined(*items), class_="signatures")


def shares(diagnosis: Diagnosis) -> Html | None:
    """What each of several diagnosed effects contributes."""
    if len(diagnosis.shares) < 2:
        return None
    rows = [
        element(
            "tr",
            element("th", plain(effect), scope="row"),
            element("td", _meter(share)),
        )
        for effect, share in diagnosis.shares.items()
    ]
    return element(
        "section",
        element("h2", "How much each effect accounts for"),
        element("table", element("tbody", joined(*rows)), class_="shares"),
        element("p", "What leaving it out of the final model would lose.", class_="note"),
    )


def ambiguous(diagnosis: Diagnosis) -> Html | None:
    """Effects that these recordings cannot tell apart."""
    if not diagnosis.ambiguous:
        return None
    groups = (
        element(
            "li",
            f"{listed(group, 'or').capitalize()}: on these recordings they give the same signal.",
        )
        for group in diagnosis.ambiguous
    )
    return element(
        "section", element("h2", "What cannot be told apart"), element("ul", joined(*groups))
    )
