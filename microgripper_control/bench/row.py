"""What a row of the table is: what is measured, against what, with which goal, and whether met."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from microgripper_control.bench.timing import Spread

Choice = TypeVar("Choice")

FASTER, LONGER = "times as fast", "times as long"
MET, MISSED = "met", "missed"


@dataclass(frozen=True)
class Goal:
    """A bound on the figure of a line."""

    limit: float
    at_least: bool

    def met(self, value: float) -> bool:
        """Whether a value keeps to it."""
        return value >= self.limit if self.at_least else value <= self.limit


def at_least(limit: float) -> Goal:
    """The figure should not be smaller."""
    return Goal(limit, at_least=True)


def at_most(limit: float) -> Goal:
    """The figure should not be larger."""
    return Goal(limit, at_least=False)


@dataclass(frozen=True)
class Line:
    """One measured figure; its `unit` says what it is: s, a ratio, a share.

    `ours` and `theirs` are times in s where the figure is a ratio of two. What was looked for may
    be `below` the figure, and how far is not known.
    """

    what: str
    against: str
    figure: Spread
    unit: str
    goal: Goal | None = None
    ours: float | None = None
    theirs: float | None = None
    below: bool = False

    @property
    def outcome(self) -> str:
        """Met, missed, or nothing where there is no goal; NaN misses."""
        if self.goal is None:
            return ""
        return MET if self.goal.met(self.figure.median) else MISSED


@dataclass(frozen=True)
class Curve:
    """How a cost grows, for the plot: two rows of numbers."""

    name: str
    of: str  # with its unit
    x: tuple[float, ...]
    y: tuple[float, ...]
    unit: str


@dataclass(frozen=True)
class Measured:
    """What came of a row; `notes` say how it was measured, `skipped` why it was not.

    It is `broken` where that is a mistake of ours, not what this machine lacks.
    """

    lines: tuple[Line, ...] = ()
    notes: tuple[str, ...] = ()
    curves: tuple[Curve, ...] = ()
    skipped: str = ""
    broken: bool = False


@dataclass(frozen=True)
class Effort:
    """How much is measured: all of it, or in `quick` runs as little as still shows the ratios."""

    folder: Path  # for whatever a row has to write
    quick: bool = False
    progress: Callable[[str], None] = field(default=lambda what: None)

    @property
    def rounds(self) -> int:
        """How often contestants that are quick take their turns."""
        return 7 if self.quick else 25

    @property
    def few_rounds(self) -> int:
        """The same for contestants that take seconds."""
        return 2 if self.quick else 5

    def among(self, whole: Choice, quick: Choice) -> Choice:
        """One of two, by how much is measured."""
        return quick if self.quick else whole


@dataclass(frozen=True)
class Row:
    """One row; raises MicrogripperError from `measure` where it cannot be measured."""

    name: str
    title: str
    measure: Callable[[Effort], Measured]
