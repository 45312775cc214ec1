"""A page as a real browser without a screen makes it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
PROGRAM = next((program for name in NAMES if (program := shutil.which(name))), None)
OPTIONS = (
    "--headless=new",
    "--no-sandbox",  # which a container's root cannot have
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--enable-logging=stderr",
    "--virtual-time-budget=10000",  # ms, of the page's own clock: it is done long before
)
LONGEST = 120.0  # s
POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*>')

MEASURE = """
  const scrolls = (element) => BOXES && element.closest(".scroll") !== null;
  const wide = [...document.querySelectorAll("body *")].filter((element) =>
    !scrolls(element) && element.getBoundingClientRect().right > innerWidth + 0.5);
  const page = document.documentElement.scrollWidth;
  const drawn = document.querySelectorAll("figure[data-drawn=true]").length;
  parent.postMessage([innerWidth, page, drawn, wide.map((e) => e.outerHTML.slice(0, 80))], "*");
"""
FRAME = """<!doctype html><title>frame</title><script>
  addEventListener("message", (event) => {
    document.documentElement.dataset.found = JSON.stringify(event.data);
  });
  </script><iframe src="used.html" style="width: %dpx; height: 740px; border: 0"></iframe>
"""

needs_browser = pytest.mark.skipif(
    PROGRAM is None, reason="no browser to look at the page with: apt-get install chromium"
)


class Elements(HTMLParser):
    """All elements of a page with their attributes, in order, and all its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.all: list[tuple[str, dict[str, str]]] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.all.append((tag, {name: value or "" for name, value in attrs}))

    def handle_data(self, data: str) -> None:
        self.text += data

    def named(self, tag: str) -> list[dict[str, str]]:
        return [attributes for name, attributes in self.all if name == tag]


def run(page: Path, profile: Path, *options: str) -> tuple[str, list[str]]:
    """What a run of the browser prints, and the lines of the page's console."""
    assert PROGRAM is not None
    command = [PROGRAM, *OPTIONS, f"--user-data-dir={profile}", *options, page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=True)
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def shown(page: Path, profile: Path) -> tuple[Elements, list[str]]:
    """The page after its scripts have run, and the lines of its console."""
    document, console = run(page, profile, "--dump-dom")
    return Elements(document), console


def with_script(page: Path, script: str, copy: Path) -> Path:
    """A copy of the page that runs a script of ours after its own."""
    text = POLICY.sub("", page.read_text(encoding="utf-8"))
    block = f"<script>{{{script}}}</script></body>"  # with names of its own
    copy.write_text(text.replace("</body>", block), encoding="utf-8")
    return copy


class Framed(NamedTuple):
    """What a page does in a frame: elements that make it scroll sideways, and figures drawn."""

    too_wide: list[str]
    drawn: int


def framed(page: Path, folder: Path, width: int, printed: bool = False) -> Framed:
    """A page in a frame of so many pixels' width.

    In a frame: the browser's own window cannot be as narrow as a phone. Where a box of its own
    scrolls the page does not; on paper nothing scrolls.
    """
    copy = with_script(
        page, MEASURE.replace("BOXES", str(not printed).lower()), folder / "used.html"
    )
    if printed:
        text = copy.read_text(encoding="utf-8")
        assert "@media print {" in text
        copy.write_text(text.replace("@media print {", "@media all {"), encoding="utf-8")
    (folder / "frame.html").write_text(FRAME % width, encoding="utf-8")
    elements, console = shown(folder / "frame.html", folder / "profile")
    assert console == []
    inner, scrolled, drawn, wide = json.loads(elements.named("html")[0]["data-found"])
    assert inner == width
    return Framed(wide or ["the page"] * (scrolled > width), drawn)
