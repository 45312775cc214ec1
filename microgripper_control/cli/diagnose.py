"""`microgripper diagnose`: why the rig differs from its model, from recordings alone."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from microgripper_control.cli.options import (
    HoldOption,
    InitialOption,
    JobsOption,
    JsonOption,
    MapOption,
    ModelOption,
    read_all,
    read_model,
    warn,
)
from microgripper_control.cli.progress import Show, progress_bar
from microgripper_control.cli.stopping import interruptible
from microgripper_control.cli.tables import print_table
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import check_place
from microgripper_control.core.quantities import quantity
from microgripper_control.core.recording import refuse_twice
from microgripper_control.diagnosis.answers.places import where
from microgripper_control.diagnosis.diagnose import candidate_names
from microgripper_control.diagnosis.diagnose import diagnose as find_causes
from microgripper_control.diagnosis.findings import Candidate, Diagnosis
from microgripper_control.diagnosis.result_file import (
    MODEL,
    NEXT_EXPERIMENT,
    REPORT,
    RESULT,
    as_json,
    write_result,
)
from microgripper_control.diagnosis.search.rounds import Progress
from microgripper_control.diagnosis.search.schedule import cluster
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.range_check import range_warnings
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model_file import save_model
from microgripper_control.plant.simulate import Initial
from microgripper_control.report.diagnosis_page import write_diagnosis_report

HELDOUT = "--heldout"
SHOWN = 6  # candidates in the printed table


def diagnose(
    recordings: Annotated[list[Path], typer.Argument(metavar="RECORDING...")],
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", metavar="DIR")],
    heldout: Annotated[
        list[Path] | None,
        typer.Option(
            HELDOUT,
            metavar="RECORDING...",
            help="Recordings that judge and are not fitted (if they alone show the gap, half of"
            " their blocks are); without any, blocks are held out of what is given.",
        ),
    ] = None,
    maps: MapOption = None,
    hold: HoldOption = Hold.ZERO,
    initial: InitialOption = Initial.FIRST_SAMPLE,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="Leave an effect out of the library. May be repeated."),
    ] = None,
    jobs: JobsOption = -1,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="tcp://HOST:PORT", help="A Dask scheduler to send the work to."),
    ] = None,
    json_: JsonOption = False,
) -> None:
    """Say where simulation and rig differ, which effect causes it and how far it shrinks."""
    judging = heldout or []
    twice = {*map(os.path.realpath, recordings)} & {*map(os.path.realpath, judging)}
    if twice:
        raise MicrogripperError(
            f"{HELDOUT}: {min(twice)} is also given to be fitted; give it one way only"
        )
    left_out = [_candidate(name) for name in without or []]
    nominal = read_model(model)
    for name in (MODEL, RESULT, REPORT, NEXT_EXPERIMENT):
        check_place(out / name, [model, *recordings, *judging])
    given, kept_apart = read_all(recordings, maps), read_all(judging, maps)
    refuse_twice([*given, *kept_apart])
    conditions = Conditions(hold, initial)
    told = range_warnings(nominal, [*given, *kept_apart])
    for warning in told:
        warn(warning)
    with (
        interruptible(),
        cluster(scheduler),
        progress_bar("nominal model, refit and noise floor") as show_step,
    ):
        found = find_causes(
            nominal, given, kept_apart, conditions, trying(show_step), jobs, left_out
        )
    write_files(found, out, maps or ())
    if json_:
        typer.echo(json.dumps(as_json(found, out), allow_nan=False))
        return
    show(found, Console(highlight=False, soft_wrap=True), told)
    more = [NEXT_EXPERIMENT] if found.next_experiment else []
    typer.echo(f"written: {', '.join([str(out / REPORT), RESULT, MODEL, *more])}")


def _candidate(name: str) -> str:
    """The name of an effect that may be left out."""
    if name not in candidate_names():
        known = ", ".join(candidate_names())
        raise MicrogripperError(f"--without {name}: is no effect that is tried; those are {known}")
    return name


def write_files(found: Diagnosis, folder: Path, maps: Sequence[str] = ()) -> None:
    """Write the model, the result and the report into a folder; `maps` as in the command line."""
    (folder / RESULT).unlink(missing_ok=True)  # it is written last: with it, all is there
    save_model(found.model, folder / MODEL)
    write_diagnosis_report(found, folder / REPORT, maps)
    write_result(found, folder)


def show(found: Diagnosis, console: Console, told: Collection[str] = ()) -> None:
    """Print the verdict, the most probable candidates and where the gap lies.

    Not so the warnings that have been `told` already.
    """
    for warning in found.warnings:
        if warning not in told:
            console.print(f"warning: {warning}", markup=False)
    console.print(found.sentence, markup=False)
    header = ("answer", "stage", "probability", "present", "held-out error")
    print_table(console, header, map(_row, found.candidates[:SHOWN]), texts=(0, 1))
    for place in found.where:
        console.print(f"where: {where(place)}", markup=False)
    for group in found.ambiguous:
        console.print(f"these recordings cannot tell apart: {', '.join(group)}")
    if found.next_experiment:
        console.print(f"next: {found.next_experiment.why}", markup=False)


def _row(candidate: Candidate) -> tuple[str, ...]:
    error = "" if candidate.rmse is None else quantity(candidate.rmse, "m", 3)
    shares = (f"{share:.2f}" for share in (candidate.probability, candidate.present))
    return candidate.effect, candidate.stage or "", *shares, error


def spread_heldout(arguments: Sequence[str]) -> list[str]:
    """`--heldout A B` as `--heldout A --heldout B`, which is what the parser understands."""
    spread: list[str] = []
    within = wanting = missing = False  # wanting: `--heldout` has no value yet
    for argument in arguments:
        name, given, value = argument.partition("=")
        if argument.startswith("-"):
            missing |= wanting
            within = name == HELDOUT
            wanting = within and not given
            if not wanting:
                spread += [HELDOUT, value] if within else [argument]
        else:
            wanting = False
            spread += [HELDOUT, argument] if within else [argument]
    if missing or wanting:
        spread.append(HELDOUT)  # the parser says that a value is missing
    return spread


def trying(show_step: Show) -> Progress:
    """Shows which effect has been tried, of those tried now."""
    return lambda what, done, total: show_step(what or "trying effects", done, total)
