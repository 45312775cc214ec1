"""`microgripper validate`: whether the diagnosis can be trusted, on rigs it has never seen."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from microgripper_control.cli.options import JobsOption, JsonOption, warn
from microgripper_control.cli.progress import Show, progress_bar
from microgripper_control.cli.stopping import interruptible
from microgripper_control.cli.tables import print_table
from microgripper_control.core.files import make_folder
from microgripper_control.diagnosis.search.schedule import cluster
from microgripper_control.examination.folder import Folder, write_json
from microgripper_control.examination.plan import MOST, USED, Extent, Part, plan
from microgripper_control.examination.run import OnProgress, run
from microgripper_control.examination.score import Score, score
from microgripper_control.examination.summary import as_json


def validate(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the results go.")],
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="About 40 cases with brief recordings, not several hundred: some 15 minutes.",
        ),
    ] = False,
    seed: Annotated[
        int,
        typer.Option(
            min=0,
            max=MOST,
            help=f"Decides all cases. Those of {USED[0]} to {USED[-1]} were learned from.",
        ),
    ] = USED.stop,
    only: Annotated[
        Part | None, typer.Option(help="Only these of its cases. The others may follow.")
    ] = None,
    first: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            help="Only N of these cases; they are shuffled, so any N are fair. More may follow.",
        ),
    ] = None,
    jobs: JobsOption = -1,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="tcp://HOST:PORT",
            help="A Dask scheduler to send the cases to; its workers must see DIR under the same"
            " path.",
        ),
    ] = None,
    json_: JsonOption = False,
) -> None:
    """Examine the diagnosis on recordings whose cause it is not told; goes on where it stopped.

    A case takes about 2 MB in DIR. The result is DIR/validation.html and validation.json.
    """
    planned = plan(seed, quick)
    extent = Extent(seed, quick, only, first)
    if extent.caution:
        warn(extent.caution)
    root = make_folder(out)
    with (
        interruptible(),
        cluster(scheduler),
        progress_bar("the first cases", lines=True) as show_step,
    ):
        records = run(root, planned, _counting(show_step), jobs, asked=extent.of(planned))
    found = score(Folder(root.resolve()), records)
    content = as_json(found, extent)
    write_json(root / "validation.json", content)
    # Drawing needs matplotlib, which takes a second: not for the other commands.
    from microgripper_control.report.validation_page import write_validation_page

    page = write_validation_page(found, root, extent)
    if json_:
        typer.echo(json.dumps(content, allow_nan=False))
        return
    show(found, Console(highlight=False, soft_wrap=True))
    typer.echo(f"written: {page}, validation.json")


def show(found: Score, console: Console) -> None:
    """Print what must hold, whether it does, and what went wrong."""
    from microgripper_control.report.validation_page import (
        TARGET_HEADER,
        TARGET_TEXTS,
        target_rows,
    )

    print_table(console, TARGET_HEADER, target_rows(found), texts=TARGET_TEXTS, folded=(0,))
    for one in found.confusions:
        reasons = "; ".join(one.reasons)
        console.print(
            f"{one.asked} taken for {one.said} ({', '.join(one.cases)}): {reasons}", markup=False
        )
    for name, outcome, why in found.failures:
        console.print(f"{name}: {outcome}: {why}", markup=False)


def _counting(show_step: Show) -> OnProgress:
    """Shows how many cases are done, and the time left."""

    def advance(done: int, total: int, left: float | None) -> None:
        text = "" if left is None else f", about {_time(left)} left"
        show_step(f"{done} of {total} cases{text}", done, total)

    return advance


def _time(seconds: float) -> str:
    minutes = round(seconds / 60.0)
    if minutes < 1:
        return f"{seconds:.0f} s"
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes} min"
