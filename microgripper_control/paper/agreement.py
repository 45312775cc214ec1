"""One line of the comparison between the paper and what comes out here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


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

    @property
    def difference(self) -> float | None:
        """Ours relative to the paper's, less one; None where the paper prints nothing."""
        return None if not self.paper else self.ours / self.paper - 1.0

    @property
    def cells(self) -> tuple[str, str, str, str, str, str, str]:
        """Where, what, unit, the paper's value, ours, the relative difference, the remark."""
        paper = "-" if self.paper is None else format(self.paper, self.form)
        difference = "-" if self.difference is None else f"{_percent(self.difference)} %"
        ours = format(self.ours, self.form)
        return self.where, self.what, self.unit, paper, ours, difference, self.remark


def _percent(share: float) -> str:
    """With two decimals and a sign, and zero always the same."""
    return f"{round(100.0 * share, 2) + 0.0:+.2f}"


HEADER = ("in the paper", "quantity", "unit", "paper", "here", "difference", "remark")


@dataclass(frozen=True)
class Table:
    """A table that has no counterpart in print; `texts` are the columns that are no numbers."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    note: str = ""
    texts: tuple[int, ...] = (0,)
