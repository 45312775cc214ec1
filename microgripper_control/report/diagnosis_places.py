"""Where a gap lies: one sentence a range, and the range drawn on the axis it is of."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.answers.places import AXES, where
from microgripper_control.diagnosis.findings import Diagnosis, Judged, Range
from microgripper_control.diagnosis.signs.where import recent_rate
from microgripper_control.report.markup import Html, element, joined
from microgripper_control.report.residual_views import Holds
from microgripper_control.report.wording import number, scaled, unbroken

LOGARITHMIC = ", log scale"
NARROWEST = 1.0  # % of the axis, so that a line in a spectrum is seen


def places(diagnosis: Diagnosis) -> Html | None:
    """The where-lines."""
    if not diagnosis.where:
        return None
    items = (
        element("li", element("p", unbroken(where(found))), _strip(found, diagnosis))
        for found in diagnosis.where
    )
    return element(
        "section", element("h2", "Where it lies"), element("ul", joined(*items), class_="places")
    )


def _ends(signal: Array) -> tuple[float, float]:
    return float(np.min(signal)), float(np.max(signal))


def _holds(recording: Recording) -> tuple[float, float]:
    longest = np.max(Holds.of(recording).since, initial=2.0 * recording.sample_period)
    return recording.sample_period, float(longest)


# How far each axis reaches in a recording; a direction has no axis to draw.
REACH: dict[str, Callable[[Judged], tuple[float, float]]] = {
    "frequency_Hz": lambda j: (1.0 / j.recording.duration, 0.5 / j.recording.sample_period),
    "displacement_m": lambda j: _ends(j.position),
    "voltage_V": lambda j: _ends(j.recording.voltage),
    "rate_V_per_s": lambda j: (0.0, float(np.max(recent_rate(j.recording)))),
    "time_s": lambda j: (0.0, j.recording.duration),
    "hold_time_s": lambda j: _holds(j.recording),
}


def _strip(found: Range, diagnosis: Diagnosis) -> Html | None:
    """The axis as far as the judging recordings reach, with the range on it."""
    if found.axis not in REACH:
        return None
    ends = [REACH[found.axis](judged) for judged in diagnosis.judged]
    low = min([found.low, *(low for low, _ in ends)])
    high = max([found.high, *(high for _, high in ends)])
    name, unit, _ = AXES[found.axis]
    course, remark = _course(found, low)

    def share(value: float) -> float:
        a, b, v = map(course, (low, high, value))
        return 100.0 * (v - a) / (b - a) if b > a else 0.0

    left, right = share(found.low), share(found.high)
    width = max(right - left, NARROWEST)
    mark = element(
        "span", class_="bar", style=f"left:{min(left, 100.0 - width):.2f}%;width:{width:.2f}%"
    )
    factor, prefixed = scaled(unit, max(abs(low), abs(high)))
    title = f"{name}{remark}"
    return element(
        "div",
        element("div", mark, class_="axis"),
        element("span", f"{number(factor * low, 2)} {prefixed}"),
        element("span", title),
        element("span", f"{number(factor * high, 2)} {prefixed}"),
        class_="strip",
        aria_hidden="true",
    )


def _course(found: Range, low: float) -> tuple[Callable[[float], float], str]:
    """How the axis runs, and how that is said; rates go over decades from zero on."""
    if found.axis == "rate_V_per_s":
        knee = max(abs(found.low), abs(found.high)) / 3.0 or 1.0
        return lambda rate: math.asinh(rate / knee), LOGARITHMIC
    if found.axis in ("frequency_Hz", "hold_time_s") and low > 0.0:
        return math.log, LOGARITHMIC
    return lambda value: value, ""
