"""The demo's figures and page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.demo.tracking import Tracking
from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.identification.fit import Fit
from microgripper_control.identification.nuisance import Conditions, predict
from microgripper_control.report.figures import FOURTH, MEASURED, SIMULATED, THIRD, figure, label
from microgripper_control.report.page import Page

COLOURS = {"feedforward": THIRD, "pid": FOURTH, "cascade": SIMULATED}
MICRO = 1e6
MOST_SHOWN = 0.999  # of the errors: a start from rest is cut off
MOST_POINTS = 4000  # of a drawn line
HISTOGRAM = 5.0  # half its width, in standard deviations


@dataclass(frozen=True)
class Shown:
    """A table, as printed and as put on the page."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Chapter:
    """A part of the page."""

    title: str
    sentences: Sequence[str]
    tables: Sequence[Shown]
    figures: Sequence[tuple[Path, str]]  # PNG and caption
    notes: Sequence[str] = ()  # on the tables
    link: tuple[str, str] | None = None  # text and address


def draw_loop(path: Path, recording: Recording, found: Fit) -> None:
    """Hysteresis loop, measured and by the identified model, and what is between them."""
    prediction = predict(found.model, recording, Conditions(), found.nuisances[0])
    every = slice(None, None, max(1, len(recording) // MOST_POINTS))
    with figure(path, (8.0, 3.6)) as drawn:
        loop, rest = drawn.subplots(1, 2)
        voltage = recording.voltage[every]
        loop.plot(
            voltage, MICRO * recording.measured[every], color=MEASURED, lw=1, label="recorded"
        )
        loop.plot(voltage, MICRO * prediction[every], "--", color=SIMULATED, lw=0.8, label="model")
        loop.legend()
        label(loop, "voltage (V)", "displacement (µm)", "Hysteresis, recorded and identified")
        error = 1e9 * (recording.measured - prediction)
        reach = HISTOGRAM * float(np.std(error))
        rest.hist(error, bins=np.linspace(-reach, reach, 81), color=MEASURED)
        label(rest, "recorded minus model (nm)", "samples", "What the model leaves")


def draw_tracking(path: Path, recording: Recording, parts: Sequence[Tracking]) -> None:
    """Setpoint and displacement of each mode over one another, and their differences."""
    assert recording.setpoint is not None
    modes = list(dict.fromkeys(part.mode for part in parts))
    runs = {mode: [part for part in parts if part.mode == mode] for mode in modes}
    spans = {mode: slice(own[0].start, own[-1].stop) for mode, own in runs.items()}
    longest = max(span.stop - span.start for span in spans.values())
    largest = 0.0
    with figure(path, (8.0, 5.5)) as drawn:
        course, error = drawn.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        for mode, span in spans.items():
            # They end together: the beginning of the first may not have been recorded.
            begin = longest - (span.stop - span.start)
            time = recording.sample_period * np.arange(begin, longest)
            wanted, reached = recording.setpoint[span], recording.measured[span]
            if mode == modes[0]:
                course.plot(time, MICRO * wanted, color=MEASURED, lw=1.6, label="setpoint")
            course.plot(time, MICRO * reached, color=COLOURS[mode], lw=0.8, label=mode)
            missed = MICRO * (wanted - reached)
            error.plot(time, missed, color=COLOURS[mode], lw=0.8, label=mode)
            largest = max(largest, float(np.quantile(np.abs(missed), MOST_SHOWN)))
        course.legend(ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.05))
        label(course, "", "displacement (µm)", "Tracking")
        label(error, "time (s)", "setpoint minus\ndisplacement (µm)")
        error.set_ylim(-1.1 * largest, 1.1 * largest)


def draw_gap(path: Path, found: Diagnosis) -> None:
    """What the model leaves of a recording, before and after the diagnosed effects are added."""
    judged = found.judged[0]
    time, measured = judged.recording.time, judged.recording.measured
    every = slice(None, None, max(1, len(time) // MOST_POINTS))
    with figure(path, (8.0, 3.2)) as drawn:
        axes = drawn.subplots()
        for name, prediction, rmse, colour in (
            ("before", judged.nominal, found.gap.nominal, SIMULATED),
            ("after", judged.augmented, found.gap.augmented, MEASURED),
        ):
            error = 1e9 * (measured - prediction)[every]
            text = f"{name}: {1e9 * rmse:.0f} nm rms"
            axes.plot(time[every], error, color=colour, lw=0.6, label=text)
        axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0))
        label(axes, "time (s)", "recorded minus model (nm)", "The gap, before and after")


def write_demo_page(path: Path, chapters: Sequence[Chapter]) -> None:
    """The page: what happened, the tables as printed and the figures, chapter by chapter."""
    page = Page("A simulated microgripper, controlled, identified and diagnosed")
    for chapter in chapters:
        page.heading(chapter.title)
        for sentence in chapter.sentences:
            page.paragraph(sentence)
        for shown in chapter.tables:
            page.caption(shown.title)
            page.table(shown.header, shown.rows)
        for note in chapter.notes:
            page.note(note)
        for png, caption in chapter.figures:
            page.figure(png, caption)
        if chapter.link:
            page.link(*chapter.link)
    page.write(path)
