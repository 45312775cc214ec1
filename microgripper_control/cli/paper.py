"""`microgripper paper`: every table and figure of the paper, recomputed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from microgripper_control.cli.options import JsonOption
from microgripper_control.cli.progress import progress_bar, step_by_step
from microgripper_control.core.files import make_folder

if TYPE_CHECKING:
    from microgripper_control.paper.reproduction import Reproduction


def paper(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the results go.")],
    json_: JsonOption = False,
) -> None:
    """Recompute the paper's tables and figures beside its own values."""
    # python-control imports matplotlib, which takes a second: not for the other commands.
    from microgripper_control.paper.agreement import summary
    from microgripper_control.paper.reproduction import STAGES, reproduce
    from microgripper_control.report.paper_chapters import CHAPTERS
    from microgripper_control.report.paper_page import write_report

    make_folder(out)
    with progress_bar() as show_step:
        progress = step_by_step(show_step, STAGES + CHAPTERS)
        result = reproduce(progress)
        page = write_report(result, out, progress)
    if json_:
        typer.echo(json.dumps(_as_json(result) | {"page": str(page)}))
        return
    typer.echo(f"{summary(result.rows())}. {len(result.slips())} slips")
    typer.echo(f"written: {page}")


def _as_json(result: Reproduction) -> dict[str, Any]:
    """The table of agreement and the slips; units beside the values."""
    rows = [
        {
            "where": row.where,
            "quantity": row.what,
            "unit": row.unit,
            "paper": row.paper,
            "here": row.ours,
            "kind": None if row.paper is None else row.kind.value,
            "relative_difference": row.difference,
            "bound_kept": row.kept,
            "remark": row.remark,
        }
        for row in result.rows()
    ]
    return {"schema": "microgripper-paper/1", "rows": rows, "slips": result.slips()}
