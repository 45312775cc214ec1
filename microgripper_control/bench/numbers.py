"""Numbers as people read them."""

from __future__ import annotations

from microgripper_control.bench.row import Goal, Line

PREFIXES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))


def seconds(value: float) -> str:
    """A time in the unit that suits its size."""
    size, unit = next((p for p in PREFIXES if abs(value) >= p[0]), PREFIXES[-1])
    return f"{plain(value / size)} {unit}"


def plain(value: float) -> str:
    """Three digits, without a power of ten from 1e-4 on."""
    if abs(value) >= 100.0:
        return f"{value:,.0f}".replace(",", " ")
    return f"{value:.3g}"


def figure(line: Line) -> str:
    """The figure of a line, with its quartiles where it was measured more than once."""
    low, median, high = line.figure
    if line.below:
        return f"below {plain(median)} {line.unit}"
    if line.unit == "s":
        return seconds(median)
    text = f"{plain(median)} {line.unit}"
    return text if low == high else f"{text} [{plain(low)}, {plain(high)}]"


def bound(line: Line) -> str:
    """The goal of a line."""
    goal: Goal | None = line.goal
    if goal is None:
        return ""
    limit = seconds(goal.limit) if line.unit == "s" else f"{plain(goal.limit)} {line.unit}"
    return f"{'at least' if goal.at_least else 'at most'} {limit}"


def spent(value: float | None) -> str:
    """One side's time, if it was measured."""
    return "" if value is None else seconds(value)
