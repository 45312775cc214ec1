"""The report on the paper: `paper.html`, its figures, and `paper.md`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from microgripper_control.core.files import written_whole
from microgripper_control.paper.agreement import HEADER, Row, Table
from microgripper_control.paper.assumptions import ASSUMPTIONS
from microgripper_control.paper.reproduction import Reproduction
from microgripper_control.report.page import Page
from microgripper_control.report.paper_chapters import Chapter, chapters

TITLE = "The paper, recomputed"
INTRODUCTION = (
    '"Hysteresis Modeling of Amplified Piezoelectric Stack Actuator for the Control of the '
    'Microgripper": every table and figure with a computation behind it, computed again from what '
    "the paper states, beside the paper's own values. Written by the command microgripper paper."
)
ASSUMED = "What the paper does not state, and what is taken instead"
SLIPS = "Slips found in the paper"
TEXT_COLUMNS = (0, 1, 6)  # of the agreement


def write_report(
    result: Reproduction, folder: Path, progress: Callable[[str], None] = lambda stage: None
) -> Path:
    """Write `paper.html`, `paper.md` and the figures into a folder; returns the page's path.

    Each file appears whole or not at all. Raises MicrogripperError where it cannot be written.
    """
    parts = chapters(result)
    page = Page(TITLE)
    page.paragraph(INTRODUCTION)
    page.heading(ASSUMED)
    page.points(ASSUMPTIONS)
    for chapter in parts:
        progress(f"figures: {chapter.title}")
        _add_chapter(page, chapter, folder)
    page.heading(SLIPS)
    page.points(result.slips())
    with written_whole(folder / "paper.md") as file:
        file.write(markdown(result))
    path = folder / "paper.html"
    page.write(path)
    return path


def _add_chapter(page: Page, chapter: Chapter, folder: Path) -> None:
    page.heading(chapter.title)
    page.paragraph(chapter.text)
    page.table(HEADER, [row.cells for row in chapter.rows], TEXT_COLUMNS)
    for drawing in chapter.drawings:
        png = folder / f"{drawing.name}.png"
        drawing.draw(png)
        page.figure(png, drawing.caption)
    for table in chapter.tables:
        page.caption(table.title)
        page.table(table.header, table.rows, table.texts)
        if table.note:
            page.note(table.note)


def markdown(result: Reproduction) -> str:
    """The agreement, the slips and the further tables as Markdown, without the figures."""
    lines = [f"# {TITLE}", "", INTRODUCTION, "", f"## {ASSUMED}", ""]
    lines += [f"- {text}" for text in ASSUMPTIONS]
    lines += ["", f"## {SLIPS}", ""]
    lines += [f"- {text}" for text in result.slips()]
    for chapter in chapters(result):
        lines += ["", f"## {chapter.title}", "", chapter.text, "", *_agreement(chapter.rows)]
        for table in chapter.tables:
            lines += ["", f"### {table.title}", "", *_table(table)]
    return "\n".join(lines) + "\n"


def _agreement(rows: Sequence[Row]) -> list[str]:
    alignment = [":--" if i in TEXT_COLUMNS else "--:" for i in range(len(HEADER))]
    return [_line(HEADER), _line(alignment), *(_line(row.cells) for row in rows)]


def _table(table: Table) -> list[str]:
    alignment = [":--" if i in table.texts else "--:" for i in range(len(table.header))]
    lines = [_line(table.header), _line(alignment), *(_line(row) for row in table.rows)]
    return [*lines, "", table.note] if table.note else lines


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
