"""The table that a run prints and `docs/reliability.md` keeps."""

from __future__ import annotations

from dataclasses import dataclass, field

from invariants import Invariants

HEAD = ("fault", "injected", "survived", "worst voltage", "worst rate", "ramp begins", "recovers")


@dataclass
class Row:
    """One kind of fault; times are the worst ones, s, with how many of them there are."""

    fault: str
    injected: int = 0
    survived: int = 0
    lowest: float = float("inf")  # V
    highest: float = float("-inf")  # V
    worst_rate: float = 0.0  # V/s
    ramps: list[float] = field(default_factory=list)  # s, from the loss to the begin of the ramp
    recoveries: list[float] = field(default_factory=list)  # s, from the end of the cause
    notes: list[str] = field(default_factory=list)  # what was not survived
    remarks: list[str] = field(default_factory=list)

    def saw(self, invariants: Invariants) -> None:
        """Take over what the voltages were."""
        self.lowest = min(self.lowest, invariants.lowest)
        self.highest = max(self.highest, invariants.highest)
        self.worst_rate = max(self.worst_rate, invariants.worst_rate)

    def failed(self, why: str) -> None:
        """Say why one was not survived."""
        self.notes.append(why)

    @property
    def passed(self) -> bool:
        """Whether all were survived."""
        return self.survived == self.injected

    def cells(self) -> tuple[str, ...]:
        """The row as text."""
        voltage = f"{self.lowest:.1f} to {self.highest:.1f} V" if self.worst_rate else ""
        rate = f"{1e-3 * self.worst_rate:.2f} V/ms" if self.worst_rate else ""
        return (
            self.fault,
            f"{self.injected}",
            f"{self.survived}",
            voltage,
            rate,
            _times(self.ramps),
            _times(self.recoveries),
        )


def markdown(rows: list[Row]) -> str:
    """All rows, aligned."""
    cells = [HEAD, *(row.cells() for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [
        "| " + " | ".join(text.ljust(w) for text, w in zip(line, widths, strict=True)) + " |"
        for line in cells
    ]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines)


def _times(found: list[float]) -> str:
    """Median and worst, ms."""
    if not found:
        return ""
    ordered = sorted(found)
    return f"{1e3 * ordered[len(ordered) // 2]:.0f}, at worst {1e3 * ordered[-1]:.0f} ms"
