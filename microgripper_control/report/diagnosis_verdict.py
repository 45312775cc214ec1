"""The head of a diagnosis: the verdict in a sentence, and the errors as bars over the noise."""

from __future__ import annotations

import math
import re

from microgripper_control.diagnosis.findings import EFFECTS, UNKNOWN, Diagnosis
from microgripper_control.report.diagnosis_layers import layers
from microgripper_control.report.markup import Html, element, joined
from microgripper_control.report.wording import (
    ABSENT,
    TIMES,
    VERDICTS,
    nanometres,
    number,
    percent,
    plain,
    unbroken,
)

SENTENCE_END = re.compile(r"(?<=[.!?])\s+(?=[A-Z])")
LEAST_SPAN = 1.0  # of a bar, in logarithms: what is hardly above the noise has hardly a bar
SHORTEST_BAR = 0.6  # %, so that an error at the noise floor still has a mark


def head(diagnosis: Diagnosis) -> Html:
    """The verdict, and what to know before it is believed."""
    headline, *rest = SENTENCE_END.split(unbroken(diagnosis.sentence), 1)
    warnings = len(diagnosis.warnings)
    plural = "s" if warnings > 1 else ""
    return element(
        "header",
        element(
            "p",
            f"Diagnosis of {diagnosis.model.name}: ",
            element("strong", VERDICTS.get(diagnosis.verdict, diagnosis.verdict)),
            class_="kicker",
        ),
        element("h1", headline),
        element("p", *rest, class_="lead") if rest else None,
        element("p", element("a", f"{warnings} warning{plural}", href="#warnings"), class_="alert")
        if warnings
        else None,
    )


def key_numbers(diagnosis: Diagnosis) -> Html:
    """How large the gap is before and after, against the noise."""
    return element(
        "section",
        element("h2", "How far it shrinks", class_="silent"),
        _claim(diagnosis),
        _ladder(diagnosis),
        class_="key",
    )


def _claim(diagnosis: Diagnosis) -> Html | None:
    """The one number that sums it up, where the verdict has one."""
    gap = diagnosis.gap
    if diagnosis.verdict == EFFECTS and math.isfinite(gap.closed):
        value = percent(gap.closed)
        low, high = (number(100.0 * end, 2) for end in (gap.closed_low, gap.closed_high))
        text = f"of the removable error is gone, 95\u00a0% interval {low} to {high}\u00a0%"
    elif diagnosis.verdict == UNKNOWN and math.isfinite(gap.driven) and not gap.untold:
        value = percent(gap.driven)
        by = "a free-form model closes it"
        if gap.by_driver > gap.free_form:
            by = f"so much goes when {plain(gap.driver)} is added"
        text = f"of the removable error follows from the voltage somehow: {by}"
    else:
        return None
    return element("p", element("strong", value), f" {text}", class_="claim")


def _ladder(diagnosis: Diagnosis) -> Html:
    gap = diagnosis.gap
    floor = gap.noise_floor
    errors = [(layer, getattr(gap, layer.field)) for layer in layers(diagnosis)]
    times = [error / floor if floor > 0.0 else math.inf for _, error in errors]
    longest = max([LEAST_SPAN, *(math.log(t) for t in times if 1.0 < t < math.inf)])
    rows = []
    for (layer, error), ratio in zip(errors, times, strict=True):
        length = 100.0 * math.log(min(max(ratio, 1.0), math.exp(longest))) / longest
        bar = element(
            "span",
            class_="bar",
            style=f"width:{max(length, SHORTEST_BAR):.1f}%;background:{layer.colour}",
        )
        rows.append(
            element(
                "tr",
                element("th", layer.name, scope="row"),
                element("td", bar, class_="track"),
                element("td", f"{nanometres(error)} nm", class_="number"),
                element("td", _over_noise(ratio), class_="number faint"),
            )
        )
    noise = element(
        "tr",
        element("th", "noise floor", scope="row"),
        element("td", class_="track"),
        element("td", f"{nanometres(floor)} nm", class_="number"),
        element("td", f"1 {TIMES}", class_="number faint"),
        class_="floor",
    )
    where = "recordings kept apart" if gap.separate else "blocks the fit never saw"
    return element(
        "table",
        element(
            "caption",
            f"Error, root mean square, on {where}. Bars begin at the noise floor, on a logarithmic "
            "scale: no bar, nothing left to explain.",
        ),
        element("tbody", joined(*rows), noise),
        class_="ladder",
    )


def _over_noise(ratio: float) -> str:
    if not math.isfinite(ratio):
        return ABSENT
    return f"{number(ratio, 2 if ratio < 100.0 else 3)} {TIMES}"
