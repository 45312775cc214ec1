"""`microgripper effects`: what a model may hold, and what its parameters mean."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.console import Console

from microgripper_control.cli.options import JsonOption
from microgripper_control.cli.tables import print_table
from microgripper_control.effects.base import Link
from microgripper_control.effects.registry import link_named, registry

SUMMARY = ("link", "stage", "what it is")
PARAMETERS = ("parameter", "unit", "usual", "range", "what it is")


def effects(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[LINK...]", help="Those whose parameters to show."),
    ] = None,
    json_: JsonOption = False,
) -> None:
    """List the links of the chain and the effects beside them, or the parameters of some."""
    chosen = [link_named(name, "effects") for name in names or registry()]
    if json_:
        plain = {"schema": "microgripper-effects/1", "links": list(map(_plain, chosen))}
        typer.echo(json.dumps(plain, allow_nan=False))
        return
    console = Console(highlight=False)
    if not names:
        rows = [(link.name, link.stage.value, link.title) for link in chosen]
        print_table(console, SUMMARY, rows, texts=range(3), folded=(2,))
        console.print("microgripper effects LINK shows the parameters of one.", markup=False)
    for link in chosen if names else ():
        title = f"{link.name} ({link.stage.value}): {link.title}"
        print_table(console, PARAMETERS, _rows(link), texts=(0, 1, 3, 4), folded=(4,), title=title)
        console.print(f"after {link.source}\n", markup=False)


def _rows(link: Link) -> Sequence[tuple[str, ...]]:
    return [
        (one.name, one.unit, f"{one.nominal:g}", f"{one.low:g} .. {one.high:g}", one.description)
        for one in link.parameters
    ]


def _plain(link: Link) -> dict[str, Any]:
    """For JSON."""
    plain = {name: getattr(link, name) for name in ("name", "title", "source", "nominal")}
    return plain | {
        "stage": link.stage.value,
        "parameters": [asdict(parameter) for parameter in link.parameters],
    }
