"""A demo's new bag takes the place of the one before once it is complete, and not sooner.

The pages go with the bag that they tell of: none stands beside the bag of another run.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder

PAGE = "index.html"
DIAGNOSIS = "diagnosis"  # folder of its files
PAGES = (PAGE, f"{DIAGNOSIS}/report.html")


@contextmanager
def fresh_bag(folder: Path, name: str) -> Iterator[Path]:
    """Yield where to record the bag that shall be called so in a demo's folder.

    It goes there if nothing is raised inside; else all stays as it was. Raises MicrogripperError
    where nothing can be written.
    """
    workshop = folder / f".{name}.recording"
    shutil.rmtree(workshop, ignore_errors=True)  # of a demo that was killed
    fresh = make_folder(workshop) / name  # by that name already: its files have it, too
    try:
        yield fresh
        try:
            _replace(folder, fresh, workshop / "before")
        except OSError as error:
            raise MicrogripperError(
                f"{folder / name}: cannot be replaced: {error.strerror}"
            ) from None
    finally:
        shutil.rmtree(workshop, ignore_errors=True)


def _replace(folder: Path, fresh: Path, before: Path) -> None:
    """Put a bag in the place of the old one, which goes to `before`."""
    bag = folder / fresh.name
    fresh.stat()  # raises, before anything goes, if there is nothing to put there
    for page in PAGES:
        (folder / page).unlink(missing_ok=True)
    if bag.exists():
        bag.rename(before)
    fresh.rename(bag)
