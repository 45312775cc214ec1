"""The benchmark's plot: every figure in proportion to its goal, and how cost grows."""

from __future__ import annotations

from itertools import cycle
from pathlib import Path
from textwrap import wrap

from matplotlib.axes import Axes

from microgripper_control.bench.numbers import figure as figure_text
from microgripper_control.bench.row import MET, Curve, Line
from microgripper_control.bench.run import Bench
from microgripper_control.report.figures import MEASURED, SIMULATED, figure, label

LINE_HEIGHT = 0.3  # inch, for two rows of text
WIDTH = 11.0  # inch
MANY, FEW = 1e3, 1e-3  # times better or worse than asked for: drawn no farther out
MARKERS = "os^Dvx"  # as curves share colours
FOLDED = 70  # characters in a row


def draw_bench(path: Path, bench: Bench) -> None:
    """Draw to a PNG."""
    lines = bench.judged
    curves = [curve for measured in bench.rows.values() for curve in measured.curves]
    height = 1.0 + LINE_HEIGHT * max(len(lines), 12)
    with figure(path, (WIDTH, height)) as drawn:
        if curves:
            left, right = drawn.subplots(1, 2, width_ratios=(1.4, 1.0))
            _draw_growth(right, curves)
        else:
            left = drawn.subplots()
        _draw_goals(left, lines)


def margin(line: Line) -> float:
    """How many times better than its goal a figure is; below 1 it misses."""
    assert line.goal is not None
    value, limit = line.figure.median, line.goal.limit
    better, worse = (value, limit) if line.goal.at_least else (limit, value)
    return min(MANY, max(FEW, better / worse)) if worse > 0.0 else MANY


def _draw_goals(axes: Axes, lines: tuple[Line, ...]) -> None:
    places = range(len(lines))
    margins = [margin(line) for line in lines]
    colours = [MEASURED if line.outcome == MET else SIMULATED for line in lines]
    axes.set_axisbelow(True)
    axes.hlines(places, 1.0, margins, colors=colours, linewidth=3.0)
    axes.scatter(margins, places, color=colours, s=18, zorder=3.0)
    axes.axvline(1.0, color="black", linewidth=1.0)
    axes.set_xscale("log")
    axes.set_yticks(places, [_told(line) for line in lines], fontsize=6.5)
    axes.set_ylim(len(lines) - 0.5, -0.5)
    label(axes, "times better than the goal (left of 1, in red: missed)", "", "Goals")


def _told(line: Line) -> str:
    """What was measured and found, and beneath it what against."""
    rows = [f"{line.what}: {figure_text(line).split(' [')[0]}"]
    rows += wrap(f"against {line.against}", FOLDED) if line.against else []
    return "\n".join(rows)


def _draw_growth(axes: Axes, curves: list[Curve]) -> None:
    for curve, marker in zip(curves, cycle(MARKERS), strict=False):
        first = curve.y[0] / curve.x[0]
        costs = [y / x / first for x, y in zip(curve.x, curve.y, strict=True)]
        sizes = [x / curve.x[0] for x in curve.x]
        axes.plot(sizes, costs, marker=marker, markersize=4, label=f"{curve.name}, {curve.of}")
    axes.set_xscale("log")
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.01), max(high, 10.0))
    axes.legend(fontsize=7, loc="lower right")
    label(axes, "size, times the smallest", "cost for each, times that at the smallest", "Growth")
