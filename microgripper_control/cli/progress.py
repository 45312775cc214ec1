"""What a command is doing, on standard error: a bar that goes away again, on a terminal."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn


class Show(Protocol):
    """What a progress bar is told."""

    def __call__(self, what: str, done: int | None = None, total: int | None = None) -> None:
        """Show what is being done; how much is done, and of how much, stays if not given."""


@contextmanager
def progress_bar(first: str = "", *, lines: bool = False) -> Iterator[Show]:
    """A bar that begins with what is done `first`.

    Where that is no terminal nothing is shown, or with `lines` one line for each step.
    """
    console = Console(stderr=True)
    columns = (
        SpinnerColumn(),
        BarColumn(),
        TextColumn("{task.description}", markup=False),
        TimeElapsedColumn(),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(first, total=None)

        def show(what: str, done: int | None = None, total: int | None = None) -> None:
            bar.update(task, description=what, completed=done, total=total)
            if lines and not console.is_terminal:
                typer.echo(what, err=True)

        yield show


def step_by_step(show: Show, total: int) -> Callable[[str], None]:
    """Shows what is begun, when all that was begun before is done."""
    done = itertools.count()
    return lambda what: show(what, next(done), total)
