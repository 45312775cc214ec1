"""`microgripper demo`: the whole suite at work on a simulated rig, over real ROS 2."""

from __future__ import annotations

import importlib.util
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.demo.experiment import run_experiment
from microgripper_control.demo.plan import MODES, SEGMENTS, WARM_UP, controllers_model, true_model
from microgripper_control.demo.tracking import MOST_MISSED, Tracking, tracking
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.identification.fit import Fit, fit
from microgripper_control.plant.model import Model, Setting
from microgripper_control.plant.model_file import save_model
from microgripper_control.recordings.read import read_recording
from microgripper_control.report.demo_page import draw_loop, draw_tracking, write_demo_page

PAPERS_ERROR = 0.05  # "less than 5 %"
STEPS = len(MODES) + 3


@dataclass(frozen=True)
class Shown:
    """A table, as printed and as put on the page."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


def demo(
    out: Annotated[Path, typer.Option("--out", metavar="DIR")] = Path("out/demo"),
    seed: Annotated[int, typer.Option(help="Of the sensor noise.", min=0)] = 1,
) -> None:
    """Control, record and identify a simulated gripper; results and a page in DIR."""
    if importlib.util.find_spec("rclpy") is None:
        raise MicrogripperError(
            "demo: ROS 2 is not there; source one, or pip install 'microgripper_control[ros]'"
        )
    console = Console(highlight=False, soft_wrap=True)
    with _sigterm_as_interrupt(), _progress() as bar:
        task = bar.add_task("starting the plant and the recorder", total=STEPS)

        def advance(what: str) -> None:
            bar.update(task, description=what, advance=1)

        experiment = run_experiment(out, seed, lambda what: advance(f"recording: {what}"))
        advance("identifying the model from the bag")
        recording = read_recording(experiment.bag)
        found = fit(controllers_model(), [recording])
        save_model(found.model, out / "fitted.yaml")
        advance("drawing")
        parts = tracking(recording, experiment.runs)
        tables = [_tracking_table(parts), _identification_table(found)]
        sentences = _sentences(recording, found, parts)
        _draw(out, recording, found, parts, sentences, tables)
    for shown in tables:
        console.print(_table(shown))
    for sentence in sentences:
        console.print(sentence)
    console.print(f"page: {out / 'index.html'}")


def _draw(
    out: Path,
    recording: Recording,
    found: Fit,
    parts: Sequence[Tracking],
    sentences: Sequence[str],
    tables: Sequence[Shown],
) -> None:
    loop, course = out / "hysteresis.png", out / "tracking.png"
    draw_loop(loop, recording, found)
    draw_tracking(course, recording, parts)
    write_demo_page(
        out / "index.html",
        sentences,
        [(shown.title, shown.header, shown.rows) for shown in tables],
        [
            (loop, "The recorded loop, the identified model's, and the difference."),
            (course, "The three controllers on the same setpoints, warm-up left out."),
        ],
    )


def _tracking_table(parts: Sequence[Tracking]) -> Shown:
    segments = [name for name in SEGMENTS if name != WARM_UP]
    cells = {(part.segment, part.mode): _cell(part) for part in parts}
    rows = [
        [segment, *(cells.get((segment, mode), "not recorded") for mode in MODES)]
        for segment in segments
    ]
    title = (
        "Tracking error, rms in % of the setpoint's peak to peak "
        f"(the paper: less than {100.0 * PAPERS_ERROR:g} %)"
    )
    return Shown(title, ("segment", *MODES), rows)


def _cell(part: Tracking) -> str:
    if part.rms is None:
        return f"missed {100.0 * part.missed:.0f} %"
    return f"{100.0 * part.rms:.3f}"


def _identification_table(found: Fit) -> Shown:
    truth, start = true_model(), controllers_model()
    rows = [_parameter_row("d k/(k + k_s), m/V", _gain(truth), _gain(start), found.gain)]
    for name in ("alpha", "beta", "gamma"):
        settings = found.model.settings["bouc_wen"][name]
        values = truth.value("bouc_wen", name), start.value("bouc_wen", name)
        rows.append(_parameter_row(name, *values, settings))
    header = ("parameter", "before", "identified, 95 %", "true", "off by")
    return Shown("Identified from the bag", header, rows)


def _parameter_row(title: str, true: float, before: float, found: Setting) -> list[str]:
    low, high = found.interval or (float("nan"), float("nan"))
    identified = f"{found.value:.5g} ± {0.5 * (high - low):.1g}"
    off = f"{100.0 * (found.value / true - 1.0):+.3f} %"
    return [title, f"{before:.4g}", identified, f"{true:.5g}", off]


def _gain(model: Model) -> float:
    return model.value("bouc_wen", "d") * static_gain(model.values("second_order"))


def _sentences(recording: Recording, found: Fit, parts: Sequence[Tracking]) -> list[str]:
    lost = " ".join(recording.warnings) or "no sample was lost"
    sentences = [
        f"Recorded: {len(recording)} samples in {recording.duration:.1f} s at "
        f"{1.0 / recording.sample_period:g} Hz; {lost}.",
        "The controllers' model was 10 % off in every parameter. "
        f"Identified from the bag, it predicts the recording to {1e9 * found.rmse[0]:.1f} nm rms, "
        f"{100.0 * found.relative_rmse[0]:.3f} % of peak to peak; white noise in that: "
        f"{1e9 * found.white_noise[0]:.1f} nm.",
    ]
    if any(part.rms is None for part in parts):
        sentences.append(
            f"Where more than {100.0 * MOST_MISSED:.0f} % was missed (the plant slept through the "
            "sample, or its setpoint came late), the machine was too slow to judge the controller."
        )
    return sentences


def _table(shown: Shown) -> Table:
    table = Table(box=SIMPLE, title=shown.title, title_justify="left", title_style="bold")
    for index, column in enumerate(shown.header):
        table.add_column(column, justify="right" if index else "left", no_wrap=True)
    for row in shown.rows:
        table.add_row(*row)
    return table


def _progress() -> Progress:
    return Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    )


@contextmanager
def _sigterm_as_interrupt() -> Iterator[None]:
    """A demo that is asked to end ends its nodes first."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
