"""`microgripper demo`: the whole suite at work on a simulated rig, over real ROS 2."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from microgripper_control.cli.demo_tables import (
    before_diagnosis,
    fault_notes,
    fault_table,
    identification_table,
    sentences,
    tracking_table,
)
from microgripper_control.cli.diagnose import show, trying, write_files
from microgripper_control.cli.identify import as_json as identification_json
from microgripper_control.cli.options import JsonOption
from microgripper_control.cli.progress import progress_bar, step_by_step
from microgripper_control.cli.stopping import interruptible
from microgripper_control.cli.tables import print_table
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder
from microgripper_control.demo.experiment import record_fault, run_experiment
from microgripper_control.demo.fault import Fault, drawn_fault
from microgripper_control.demo.fresh_bag import DIAGNOSIS, PAGE
from microgripper_control.demo.plan import MODES, controllers_model
from microgripper_control.demo.tracking import Tracking, tracking
from microgripper_control.diagnosis.diagnose import diagnose
from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.diagnosis.result_file import as_json as diagnosis_json
from microgripper_control.effects.sensor.sensor_noise import LARGEST_SEED
from microgripper_control.identification.fit import Fit, fit
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import save_model
from microgripper_control.recordings.read import read_recording
from microgripper_control.report.demo_page import (
    Chapter,
    draw_gap,
    draw_loop,
    draw_tracking,
    write_demo_page,
)

SCHEMA = "microgripper-demo/1"


def demo(
    out: Annotated[Path, typer.Option("--out", metavar="DIR")] = Path("out/demo"),
    seed: Annotated[
        int,
        typer.Option(help="Of the sensor noise and of what goes wrong.", min=0, max=LARGEST_SEED),
    ] = 1,
    json_: JsonOption = False,
) -> None:
    """Control, record, identify, break and diagnose a simulated gripper; a page in DIR."""
    if importlib.util.find_spec("rclpy") is None:
        raise MicrogripperError(
            "demo: ROS 2 is not there; source one, or pip install 'microgripper_control[ros]'"
        )
    console, page = Console(highlight=False, soft_wrap=True, quiet=json_), out / PAGE
    with interruptible():
        fitted, parts, first = _identify(out, seed, console)
        fault = drawn_fault(seed)
        found, second = _diagnose(out, seed, fault, fitted.model, console)
    write_demo_page(page, (first, second))
    console.print(f"page: {page}", markup=False)
    if json_:
        result = {
            "schema": SCHEMA,
            "page": str(page),
            "tracking": [asdict(part) for part in parts],
            "identified": identification_json(fitted),
            "planted": asdict(fault),
            "diagnosis": diagnosis_json(found, out / DIAGNOSIS),
        }
        typer.echo(json.dumps(result, allow_nan=False))


def _identify(out: Path, seed: int, console: Console) -> tuple[Fit, Sequence[Tracking], Chapter]:
    """Control, record and identify: the fit, how well each mode tracked, and what to say of it."""
    with progress_bar() as show_step:
        advance = step_by_step(show_step, len(MODES) + 4)
        advance("starting the plant and the recorder")
        experiment = run_experiment(out, seed, lambda what: advance(f"recording: {what}"))
        advance("identifying the model from the bag")
        recording = read_recording(experiment.bag)
        found = fit(controllers_model(), [recording])
        save_model(found.model, out / "fitted.yaml")
        advance("drawing")
        parts = tracking(recording, experiment.runs)
        loop, course = out / "hysteresis.png", out / "tracking.png"
        draw_loop(loop, recording, found)
        draw_tracking(course, recording, parts)
    chapter = Chapter(
        "Controlled, recorded and identified",
        sentences(recording, found, parts),
        [tracking_table(parts), identification_table(found)],
        [
            (loop, "The recorded loop, the identified model's, and the difference."),
            (course, "The three controllers on the same setpoints, warm-up left out."),
        ],
    )
    _print(chapter, console)
    for sentence in chapter.sentences:
        console.print(sentence, markup=False)
    return found, parts, chapter


def _diagnose(
    out: Path, seed: int, fault: Fault, identified: Model, console: Console
) -> tuple[Diagnosis, Chapter]:
    """Break the rig, record it once more and find out from the bag what it was."""
    folder = make_folder(out / DIAGNOSIS)
    with progress_bar("recording the rig once more") as show_step:
        recording = read_recording(record_fault(out, fault, seed))
        found = diagnose(identified, [recording], progress=trying(show_step))
        write_files(found, folder)
        before_after = out / "gap.png"
        draw_gap(before_after, found)
    chapter = Chapter(
        "Broken, recorded once more and diagnosed",
        [before_diagnosis(found), found.sentence],
        [fault_table(fault, found)],
        [
            (
                before_after,
                "What the identified model leaves of the new recording, and what is left once it "
                "has the diagnosed effect.",
            )
        ],
        fault_notes(fault),
        ("The whole diagnosis", f"{DIAGNOSIS}/report.html"),
    )
    console.print(f"\n{chapter.sentences[0]}", markup=False)
    show(found, console)
    _print(chapter, console)
    console.print(f"report: {folder / 'report.html'}", markup=False)
    return found, chapter


def _print(chapter: Chapter, console: Console) -> None:
    for shown in chapter.tables:
        print_table(console, shown.header, shown.rows, title=shown.title)
    for note in chapter.notes:
        console.print(note, markup=False)
