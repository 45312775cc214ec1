"""An interactive figure as data: a mapping that becomes JSON, drawn by assets/*.js.

A figure has a `kind`, "lines" or "map", its axes, and series of packed values (see `decimation`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.report.decimation import extremes, packed

Figure = dict[str, object]


def series(name: str, colour: str, x: Figure | None, y: Figure, **style: object) -> Figure:
    """A line through packed values; `style`: width (pixels), dash, dots, hidden, height.

    Without an x it lies over the figure's `across`. `height`, the lowest and the highest value,
    is what the whole figure makes room for; without it, all values.
    """
    return {"name": name, "colour": colour, "x": x, "y": y, **style}


def height(values: Array) -> tuple[float, float] | None:
    """The lowest and the highest of some values; None if there are none."""
    return (float(np.min(values)), float(np.max(values))) if len(values) else None


def over_time(
    name: str, colour: str, signal: Array, sample_period: float, values: int, **style: object
) -> Figure:
    """A line over time of at most so many values: where there are more, extremes of buckets."""
    drawn = extremes(signal, values // 2)
    step = sample_period * len(signal) / len(drawn)
    start = 0.0 if len(drawn) == len(signal) else step / 2.0
    x: Figure = {"start": start, "step": step, "count": len(drawn)}
    return series(name, colour, x, packed(drawn), **style)


def lines(
    x: tuple[str, str],
    y: tuple[str, str],
    drawn: Sequence[Figure],
    logarithmic: Sequence[str] = (),
    **options: object,
) -> Figure:
    """A figure of lines; an axis is its label and unit.

    `options`: bands and levels (marked ranges of x and heights), reach (of x; else that of the
    values), linked (zooms with the others over time), flat (low), box (zooms both ways), across (x
    of lines without their own) and times (s, of these: only what the others over time show is
    drawn).
    """
    axes = {
        name: {"label": label, "unit": unit, "log": name in logarithmic}
        for name, (label, unit) in (("x", x), ("y", y))
    }
    return {"kind": "lines", **axes, "series": drawn, **options}
