"""`microgripper bench`: how fast the package is on this machine."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from microgripper_control.cli.options import JsonOption
from microgripper_control.cli.progress import progress_bar
from microgripper_control.cli.stopping import interruptible
from microgripper_control.core.files import make_folder, written_whole

if TYPE_CHECKING:
    from microgripper_control.bench.run import Bench

BROKEN = 1  # exit status when a row failed by a mistake of ours


def bench(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the results go.")],
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="ROW", help="Measure this row alone. May be repeated."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Fewer rounds and smaller sizes: about 5 minutes.")
    ] = False,
    json_: JsonOption = False,
) -> None:
    """Measure how fast everything is beside other ways of doing the same; a table and a plot."""
    # These import most of the package, and matplotlib: not for the other commands.
    from microgripper_control.bench.document import as_csv, as_json, as_markdown
    from microgripper_control.bench.row import Effort
    from microgripper_control.bench.run import run
    from microgripper_control.report.bench_figure import draw_bench

    make_folder(out)
    with interruptible(), progress_bar(lines=True) as progress:
        found = run(Effort(out, quick, progress), only or ())
    picture = out / "performance.png"
    draw_bench(picture, found)
    texts = {
        "performance.md": as_markdown(found, picture.name),
        "bench.csv": as_csv(found),
        "bench.json": json.dumps(as_json(found), indent=1) + "\n",
    }
    for name, text in texts.items():
        with written_whole(out / name) as file:
            file.write(text)
    if json_:
        typer.echo(texts["bench.json"], nl=False)
    else:
        show(found, Console(highlight=False, soft_wrap=True))
        typer.echo(f"written: {picture}, {', '.join(texts)}")
    if found.broken:
        raise typer.Exit(BROKEN)


def show(found: Bench, console: Console) -> None:
    """Print the table."""
    from microgripper_control.bench.numbers import bound, figure
    from microgripper_control.bench.run import ROWS

    for name, measured in found.rows.items():
        console.print(f"{ROWS[name].title} (--only {name})")
        if measured.skipped:
            console.print(f"  not measured: {measured.skipped}\n", markup=False)
            continue
        table = Table(box=SIMPLE, show_header=False)
        for column in ("what", "figure", "goal"):
            table.add_column(column, overflow="fold")
        for line in measured.lines:
            what = f"{line.what}, against {line.against}" if line.against else line.what
            table.add_row(what, figure(line), f"{bound(line)}: {line.outcome}".strip(": "))
        console.print(table)
    console.print(f"{found.met} of {len(found.judged)} goals met; {rows_told(found)}")


def rows_told(found: Bench) -> str:
    """How many rows were measured, and failed."""
    failed = f", {found.broken} failed" if found.broken else ""
    return f"{found.measured} of {len(found.rows)} rows measured{failed}"
