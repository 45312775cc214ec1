"""A page as a real browser without a screen makes it."""

from __future__ import annotations

import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

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
