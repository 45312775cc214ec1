"""The whole demo, as a newcomer runs it, and what is left when he stops it."""

from __future__ import annotations

import html
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from microgripper_control.demo.fault import drawn_fault
from microgripper_control.demo.plan import true_model
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model

# What a shell starts in the background, a test run too, ignores SIGINT; a demo in front does not.
COMMAND = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
from microgripper_control.cli.main import main
main()
"""
PATIENCE = 560.0  # s: less than a test may take in all

pytestmark = pytest.mark.ros

Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start() -> Iterator[Start]:
    """`start(out, "--json")` starts a demo, which does not outlive the test."""
    running: list[subprocess.Popen[str]] = []

    def start(out: Path, *words: str) -> subprocess.Popen[str]:
        running.append(
            subprocess.Popen(
                [sys.executable, "-c", COMMAND, "demo", "--out", str(out), *words],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        )
        return running[-1]

    yield start
    for process in running:
        if process.poll() is None:
            process.terminate()
            process.communicate(timeout=PATIENCE)


def nodes_logging_to(out: Path) -> list[int]:
    """Processes whose log folder, and so whose demo, this is."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            environment = (entry / "environ").read_bytes()
        except OSError:
            continue
        if f"ROS_LOG_DIR={out}".encode() in environment:
            found.append(int(entry.name))
    return found


def gain(model: Model) -> float:
    return model.value("bouc_wen", "d") * static_gain(model.values("second_order"))


def test_the_demo_identifies_and_diagnoses_its_rig_and_leaves_nothing_running(
    start: Start, tmp_path: Path
) -> None:
    out = tmp_path / "demo"
    process = start(out, "--json")
    printed, complaints = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, complaints
    assert nodes_logging_to(out) == []
    told = json.loads(printed)
    assert {part["mode"] for part in told["tracking"]} >= {"cascade", "feedforward", "pid"}
    page = (out / "index.html").read_text(encoding="utf-8")
    assert page.count("<img") == 3
    assert 'href="diagnosis/report.html"' in page
    assert (out / "diagnosis" / "report.html").exists()
    found = json.loads((out / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
    planted = drawn_fault(seed=1).effect
    assert (found["verdict"], found["effects"]) == ("effects", [planted])
    assert told["diagnosis"] == found
    assert told["planted"]["effect"] == planted
    assert html.unescape(page).count(found["sentence"]) == 1
    assert f"planted is {planted}" in page
    truth, model = true_model(), load_model(out / "fitted.yaml")
    alpha = told["identified"]["parameters"]["bouc_wen.alpha"]["value"]
    assert alpha == pytest.approx(model.value("bouc_wen", "alpha"), rel=1e-9)
    assert gain(model) == pytest.approx(gain(truth), 2.5e-3)  # k and k_s apart cannot be seen
    for name in ("alpha", "beta", "gamma"):
        identified, true = model.settings["bouc_wen"][name], truth.value("bouc_wen", name)
        assert identified.interval is not None
        low, high = identified.interval
        # Twice the interval is wider only where the machine missed a good part of the samples.
        tolerance = max(2.5e-3 * abs(true), high - low)
        assert identified.value == pytest.approx(true, abs=tolerance)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_demo_that_is_stopped_stops_its_nodes(
    hangup: None, start: Start, tmp_path: Path, number: int
) -> None:
    out = tmp_path / "demo"
    process = start(out)
    deadline = time.monotonic() + PATIENCE
    while not (out / "log" / "recorder.log").exists():  # it has started its nodes
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.05)
    os.kill(process.pid, number)
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert nodes_logging_to(out) == []
