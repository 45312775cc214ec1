"""The comparison between the paper and what comes out here, a line a quantity."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass


class Kind(str, enum.Enum):
    """What the paper's value is to ours."""

    RESULT = "result"  # found by the paper as well
    PLANTED = "planted"  # in what ours was found from: agreement says nothing of the paper
    BOUND = "bound"  # that ours is to stay below


@dataclass(frozen=True)
class Row:
    """A quantity with the paper's value and ours, both in `unit`."""

    where: str  # in the paper
    what: str
    unit: str
    ours: float
    paper: float | None = None  # None: the paper does not give it
    remark: str = ""
    form: str = ".4g"  # how the numbers are printed
    kind: Kind = Kind.RESULT

    @property
    def difference(self) -> float | None:
        """Ours relative to the paper's, less one; None of a bound, or where there is none."""
        return self.ours / self.paper - 1.0 if self.paper and self.kind != Kind.BOUND else None

    @property
    def kept(self) -> bool | None:
        """Whether ours is below the paper's bound; None where that is none."""
        return self.ours < self.paper if self.paper and self.kind == Kind.BOUND else None

    @property
    def cells(self) -> tuple[str, str, str, str, str, str, str]:
        """Where, what, unit, the paper's value, ours, how they agree, the remark."""
        below = "" if self.kept is None else "<\N{NO-BREAK SPACE}"
        paper = "-" if self.paper is None else f"{below}{self.paper:{self.form}}"
        ours = format(self.ours, self.form)
        return self.where, self.what, self.unit, paper, ours, self._agreement, self.remark

    @property
    def _agreement(self) -> str:
        """The difference with two decimals and a sign, zero always the same; or the bound's."""
        if self.kept is not None:
            return "kept" if self.kept else "broken"
        if self.difference is None:
            return "-"
        return f"{round(100.0 * self.difference, 2) + 0.0:+.2f} %"


NEAR = 0.02  # relative difference of what counts as the same
HEADER = ("in the paper", "quantity", "unit", "paper", "here", "difference", "remark")


@dataclass(frozen=True)
class Table:
    """A table that has no counterpart in print; `texts` are the columns that are no numbers."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    note: str = ""
    texts: tuple[int, ...] = (0,)


def summary(rows: Sequence[Row]) -> str:
    """How many of the paper's results come out again; its bounds and what was planted, apart."""
    results, planted = (
        [abs(row.difference) for row in rows if row.kind == kind and row.difference is not None]
        for kind in (Kind.RESULT, Kind.PLANTED)
    )
    bounds = [row.kept for row in rows if row.kept is not None]
    near = sum(difference < NEAR for difference in results)
    return (
        f"{len(rows)} quantities. Of {len(results)} printed results {near} are within "
        f"{100.0 * NEAR:g} %, of {len(bounds)} printed bounds {sum(bounds)} are kept; "
        f"{len(planted)} values that were planted come back, the farthest "
        f"{100.0 * max(planted):.1f} % off"
    )
