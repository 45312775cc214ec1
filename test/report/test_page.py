"""The page is whole, self-contained and takes no orders from a recording's name."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import pytest
from browser import framed, needs_browser

from microgripper_control.paper.headline import CASES, LAWS
from microgripper_control.report.figures import figure, label
from microgripper_control.report.page import Page

LONG = "/recordings/" + "a_rig_with_a_name_that_no_line_breaks_in_" * 2
HOSTILE = '<script>alert("bag")</script>'


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.seen: list[str] = []
        self.sources: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]


def test_hostile_text_is_shown_not_run(tmp_path: Path) -> None:
    with figure(tmp_path / "f.png") as drawn:
        axes = drawn.subplots()
        axes.plot([0.0, 1.0])
        label(axes, "time (s)", "x (um)", "a line")
    page = Page(HOSTILE)
    page.heading(HOSTILE)
    page.paragraph(HOSTILE)
    page.note(HOSTILE)
    page.table(["name", HOSTILE], [[HOSTILE, "1"]])
    page.figure(tmp_path / "f.png", HOSTILE)
    page.write(tmp_path / "page.html")
    tags = Tags()
    tags.feed((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert "script" not in tags.seen
    assert {"h1", "h2", "table", "figure"} <= set(tags.seen)
    assert all(source.startswith("data:image/png;base64,") for source in tags.sources)


def wide(folder: Path) -> Path:
    """A page with one of the paper's tables of all laws and cases, and a table of long texts."""
    page = Page("Wide")
    page.paragraph(LONG)
    page.points([LONG])
    page.note(LONG)
    page.caption(LONG)
    page.table(("law", *CASES), [(law, *["12.704 / 16.181"] * len(CASES)) for law in LAWS])
    page.table(("case", "outcome", "why"), [("case_001", "failed", f"{LONG}: {LONG}")], (0, 1, 2))
    page.write(folder / "page.html")
    return folder / "page.html"


@needs_browser
@pytest.mark.parametrize("width", [360, 500])
def test_long_names_do_not_make_it_scroll_sideways(width: int, tmp_path: Path) -> None:
    assert framed(wide(tmp_path), tmp_path, width).too_wide == []


@needs_browser
def test_every_column_is_on_the_paper(tmp_path: Path) -> None:
    """A4 at 96 pixels an inch, within the browser's margins of 1 cm."""
    assert framed(wide(tmp_path), tmp_path, 718, printed=True).too_wide == []
