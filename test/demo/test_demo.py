"""The whole demo, as a newcomer runs it, and what is left when he stops it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from microgripper_control.demo.plan import true_model
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model

COMMAND = "from microgripper_control.cli.main import main; main()"
PATIENCE = 180.0  # s

pytestmark = pytest.mark.ros


def start(out: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", COMMAND, "demo", "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


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


def test_the_demo_identifies_its_rig_and_leaves_nothing_running(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    process = start(out)
    printed, complaints = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, complaints
    assert nodes_logging_to(out) == []
    assert "cascade" in printed
    assert {"index.html", "fitted.yaml", "hysteresis.png", "tracking.png", "bag"} <= {
        entry.name for entry in out.iterdir()
    }
    truth, found = true_model(), load_model(out / "fitted.yaml")
    assert gain(found) == pytest.approx(gain(truth), 2.5e-3)  # k and k_s apart cannot be seen
    for name in ("alpha", "beta", "gamma"):
        assert found.value("bouc_wen", name) == pytest.approx(truth.value("bouc_wen", name), 2.5e-3)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_demo_that_is_stopped_stops_its_nodes(tmp_path: Path, number: int) -> None:
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
