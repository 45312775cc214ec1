"""The report of a diagnosis: one HTML file for screen, phone and print that needs no network.

The numbers are in the markup; the figures are drawn by the page's own scripts from data in it. No
other script can run on the page, whatever a recording is called: all texts are escaped, and the
page's policy names the scripts by their hashes.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path, PurePath

from microgripper_control.core.files import written_whole
from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.report import diagnosis_advice as advice
from microgripper_control.report.diagnosis_candidates import ambiguous, candidates, shares
from microgripper_control.report.diagnosis_chain import chain
from microgripper_control.report.diagnosis_figures import next_figure, recording_figures
from microgripper_control.report.diagnosis_places import places
from microgripper_control.report.diagnosis_verdict import head, key_numbers
from microgripper_control.report.markup import Html, element, joined

SCRIPTS = ("data", "scales", "axes", "gestures", "lines", "map", "page")
ASSETS = files("microgripper_control.report") / "assets"

# Name, title and caption of the figures that each recording has.
FIGURES = (
    (
        "response",
        "Measured and simulated",
        "Drag over a part to zoom, double click for the whole; the three figures over time go "
        "together. Grey: where errors are taken. Press a name to show or hide its line.",
    ),
    ("voltage", "Voltage", ""),
    (
        "residual",
        "What the model leaves",
        "Measured minus simulated. The whole range makes room for the samples that are compared: "
        "not for what answers to the time before the recording, nor for samples filled in.",
    ),
    (
        "spectrum",
        "Spectrum of the residual",
        "Amplitude density. A model that is right lies on the noise floor at all frequencies.",
    ),
    (
        "map",
        "Residual over displacement and rate",
        "Mean of measured minus simulated in each cell; white: never there. A model that is right "
        "leaves no pattern.",
    ),
    (
        "holds",
        "Residual while the voltage rests",
        "Mean over all holds; positive is onwards in the direction of the step before.",
    ),
    (
        "loops",
        "Loops",
        "Of the part of the recording that the figures over time show. Drag a rectangle to zoom.",
    ),
    (
        "hysteresis",
        "Loops without their slope",
        "The straight line that fits the measurement best is taken off measured and simulated.",
    ),
    ("directions", "Residual over voltage", "Mean while the voltage rises, and while it falls."),
)


def write_diagnosis_report(diagnosis: Diagnosis, path: Path, maps: Sequence[str] = ()) -> None:
    """Write the report as one self-contained page; it appears whole or not at all.

    The model lies beside it; `maps` are the values of `--map` that the recordings were read with.
    Raises MicrogripperError where the place cannot be written.
    """
    scripts = [_asset(f"{name}.js") for name in SCRIPTS]
    title = f"Diagnosis of {diagnosis.model.name}"
    page = element(
        "html",
        element(
            "head",
            element("meta", charset="utf-8"),
            element("meta", name="viewport", content="width=device-width, initial-scale=1"),
            element("meta", http_equiv="Content-Security-Policy", content=_policy(scripts)),
            element("title", title),
            element("style", Html(_asset("diagnosis.css"))),
        ),
        element(
            "body",
            element("main", *_sections(diagnosis, path.parent, maps)),
            _data(diagnosis),
            *_run(scripts),
        ),
        lang="en",
    )
    with written_whole(path) as file:
        file.write(f"<!doctype html>\n{page}\n")


def _sections(diagnosis: Diagnosis, folder: Path, maps: Sequence[str]) -> list[Html | None]:
    """In the order in which a technician reads."""
    return [
        head(diagnosis),
        key_numbers(diagnosis),
        chain(diagnosis),
        candidates(diagnosis),
        shares(diagnosis),
        ambiguous(diagnosis),
        places(diagnosis),
        _figures(diagnosis),
        advice.parameters(diagnosis),
        advice.next_experiment(diagnosis),
        advice.warnings(diagnosis),
        advice.repeating(diagnosis, folder, maps),
    ]


def _figures(diagnosis: Diagnosis) -> Html:
    names = _short_names([judged.recording.name for judged in diagnosis.judged])
    options = (element("option", name, value=str(index)) for index, name in enumerate(names))
    chooser = element("select", *options, id="recording", autocomplete="off")
    return element(
        "section",
        element("h2", "Before and after"),
        element("label", "Recording ", chooser, class_="chooser"),
        element("noscript", element("p", "The figures need JavaScript.", class_="alert")),
        joined(*(advice.figure(*each) for each in FIGURES)),
    )


def _short_names(names: list[str]) -> list[str]:
    """Recordings without their folders, if that still tells them apart."""
    short = [PurePath(name).name or name for name in names]
    return short if len(set(short)) == len(names) else names


def _data(diagnosis: Diagnosis) -> Html:
    """What the figures show, as JSON in which no markup can begin."""
    experiment = diagnosis.next_experiment
    content = {
        "recordings": [recording_figures(diagnosis, judged) for judged in diagnosis.judged],
        "figures": {} if experiment is None else {"next": next_figure(experiment)},
    }
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return element("script", Html(text), type="application/json", id="report-data")


def _policy(scripts: list[str]) -> str:
    """Nothing is loaded, and only the page's own scripts run."""
    hashes = (base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in scripts)
    allowed = " ".join(f"'sha256-{code}'" for code in hashes)
    return f"default-src 'none'; style-src 'unsafe-inline'; script-src {allowed}"


def _run(scripts: list[str]) -> list[Html]:
    return [element("script", Html(script)) for script in scripts]


def _asset(name: str) -> str:
    return (ASSETS / name).read_text(encoding="utf-8")
