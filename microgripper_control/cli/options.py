"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from microgripper_control.core.errors import one_line
from microgripper_control.core.recording import Recording
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.range_check import range_warnings
from microgripper_control.identification.scale_check import scale_warnings
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model
from microgripper_control.plant.simulate import Initial
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording

ModelOption = Annotated[
    Path, typer.Option("--model", metavar="MODEL.yaml", help="The model of the rig.")
]
MapOption = Annotated[
    list[str] | None,
    typer.Option(
        "--map",
        metavar="QUANTITY=NAME[:FIELD][*SCALE]",
        help="Where voltage, displacement, time or setpoint are found in other people's recordings:"
        " a column or a topic, a field of its messages, a factor to SI. May be repeated.",
    ),
]
HoldOption = Annotated[
    Hold, typer.Option("--hold", help="How the voltage runs between its samples.")
]
InitialOption = Annotated[
    Initial, typer.Option("--initial", help="The state the recording starts in.")
]
JobsOption = Annotated[
    int, typer.Option(callback=lambda jobs: _some(jobs), help="How many at once; -1: one a core.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]


def _some(jobs: int) -> int:
    if jobs == 0:
        raise typer.BadParameter("0 at once never end; -1 is one a core")
    return jobs


def warn(text: str) -> None:
    """Say on standard error, in one line, what is no error but to be known."""
    typer.echo(f"warning: {one_line(text)}", err=True)


def read_model(path: Path) -> Model:
    """Load a model; what to know before it is trusted is said on standard error."""
    model = load_model(path)
    for warning in model.warnings:
        warn(warning)
    return model


def warn_of_misuse(
    model: Model, recordings: Sequence[Recording], conditions: Conditions
) -> list[str]:
    """Say, on standard error too, where a model is not one of these recordings.

    They go beyond its range, or another way than it does: a unit may be wrong.
    """
    warnings = range_warnings(model, recordings)
    measured = [one for one in recordings if one.displacement is not None]
    if measured:
        with np.errstate(all="ignore"):  # what a damaged file holds may overflow: it is told
            warnings += scale_warnings(model, measured, conditions)
    for warning in warnings:
        warn(warning)
    return warnings


def read_all(
    paths: list[Path], maps: list[str] | None, needs_displacement: bool = True
) -> list[Recording]:
    """Read recordings; what was mended is said on standard error."""
    mapping = Mapping.parse(maps or [])
    recordings = []
    for path in paths:
        recording = read_recording(path, mapping, needs_displacement=needs_displacement)
        for warning in recording.warnings:
            warn(f"{recording.name}: {warning}")
        recordings.append(recording)
    return recordings
