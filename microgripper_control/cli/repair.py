"""`microgripper repair`: a bag whose recorder was killed, or that was damaged, made whole."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from microgripper_control.cli.options import JsonOption, warn
from microgripper_control.cli.stopping import interruptible
from microgripper_control.core.errors import one_line
from microgripper_control.recordings.repair import Repair, repair_bag


def repair(
    bag: Annotated[Path, typer.Argument(metavar="BAG", help="A rosbag2's folder.")],
    json_: JsonOption = False,
) -> None:
    """Restore index and metadata of a bag that was not closed or was damaged; the old is kept."""
    with interruptible(), Console(stderr=True).status("reading") as status:
        done = repair_bag(bag, status.update)
    for lost in done.lost:
        warn(f"{done.bag}: {lost}")
    if json_:
        typer.echo(json.dumps(_as_json(done)))
        return
    counts = ", ".join(f"{count} of {one_line(name)}" for name, count in done.messages.items())
    if done.kept is None:
        typer.echo(f"{done.bag} is whole: {counts or 'no messages'}")
        return
    typer.echo(f"{done.bag} is whole again: {counts or 'no messages'}")
    typer.echo(f"the damaged bag is kept: {done.kept}")


def _as_json(done: Repair) -> dict[str, object]:
    return {
        "schema": "microgripper-repair/1",
        "bag": str(done.bag),
        "repaired": done.kept is not None,
        "messages": done.messages,
        "lost": list(done.lost),
        "kept": None if done.kept is None else str(done.kept),
    }
