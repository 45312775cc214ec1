"""`microgripper stiffness`: a flexure's stiffness from forces and displacements."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from microgripper_control.cli.options import JsonOption
from microgripper_control.core.table import Table
from microgripper_control.identification.stiffness import Stiffness, fit_stiffness

COLUMNS = ("force_N", "displacement_m")


def stiffness(
    data: Annotated[
        Path, typer.Argument(metavar="FILE.csv", help=f"With columns {' and '.join(COLUMNS)}.")
    ],
    json_: JsonOption = False,
) -> None:
    """Fit a flexure's stiffness to measured forces and displacements (section 4 of the paper)."""
    table = Table.opened(data, ",".join(COLUMNS))
    force, displacement = table.whole_numbers([table.column(name) for name in COLUMNS]).T
    found = fit_stiffness(force, displacement, str(data))
    if json_:
        typer.echo(json.dumps({"schema": "microgripper-stiffness/1", **asdict(found)}))
        return
    low, high = found.interval
    typer.echo(f"stiffness {found.value:.5g} N/m, 95 % {low:.5g} .. {high:.5g}")
    typer.echo(f"{found.points} points, {1e6 * found.rmse:.3g} µm rms about the line{_bend(found)}")


def _bend(found: Stiffness) -> str:
    if not found.bend_seen:
        return ""
    return f"; bent by {100.0 * found.bend:.1f} % of the stroke: one stiffness is not all of it"
