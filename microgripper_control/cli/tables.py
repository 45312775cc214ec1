"""Tables on the terminal. No digit is lost: one that is too wide is printed as wide as it is."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Literal

from rich.box import SIMPLE
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

ANY_WIDTH = 10_000


def print_table(
    console: Console,
    header: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    texts: Collection[int] = (0,),
    folded: Collection[int] = (),
    title: str | None = None,
) -> None:
    """Print a table: the columns `texts` to the left, numbers to the right.

    The columns `folded` are broken where the terminal is narrow.
    """
    table = Table(box=SIMPLE, title=title, title_justify="left", title_style="bold")
    cells = [header, *rows]
    for index, column in enumerate(header):
        side: Literal["left", "right"] = "left" if index in texts else "right"
        least = 1 if index in folded else max(len(row[index]) for row in cells)
        table.add_column(column, justify=side, min_width=least, overflow="fold")
    for row in cells[1:]:
        table.add_row(*row)
    least = Measurement.get(console, console.options.update(max_width=ANY_WIDTH), table).minimum
    if least > console.width:
        table.width = least
    console.print(table)
