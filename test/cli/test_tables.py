"""What a terminal too narrow for a table still shows."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from microgripper_control.cli.tables import print_table

ROW = ("restoring_force_hysteresis", "mechanics", "0.97", "0.98", "1.2345e-05")
HEADER = ("answer", "stage", "probability", "present", "held-out error")


def printed(width: int, row: tuple[str, ...] = ROW, folded: tuple[int, ...] = ()) -> list[str]:
    console = Console(file=io.StringIO(), width=width, soft_wrap=True)
    print_table(console, HEADER, [row], texts=(0, 1), folded=folded)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue().splitlines()


@pytest.mark.parametrize("width", [20, 80, 200])
def test_nothing_is_cut_off(width: int) -> None:
    lines = printed(width)
    assert lines == printed(200)
    (row,) = (line for line in lines if ROW[0] in line)
    assert row.split() == list(ROW)


def test_a_folded_column_keeps_the_table_narrow() -> None:
    text = "the error of what a model says beside what chance alone would show"
    row = (text, *ROW[1:])
    lines = printed(80, row, folded=(0,))
    assert max(map(len, lines)) <= 80 < max(map(len, printed(80, row)))
    assert all(word in " ".join(lines[3:]) for word in text.split())
