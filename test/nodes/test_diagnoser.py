from __future__ import annotations

import json
import math
import re
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter as RosParameter
from running_nodes import Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import load_model, save_model
from microgripper_control.recordings.read import read_recording

pytestmark = pytest.mark.ros

RATE = 200  # Hz: enough for the effect, and quick to diagnose
NOISE = 15e-9
DELAY = 2.0 / RATE
SERVICE = "diagnoser/diagnose"


def voltage(seconds: float) -> float:
    """A wave on steps."""
    steps = 35.0 * math.sin(7.1 * math.floor(seconds / 0.3))
    return 80.0 + steps + 30.0 * math.sin(2.6 * math.pi * seconds)


class Bench:
    """Drives the plant and reads the nodes' health."""

    def __init__(self, watcher: Watcher) -> None:
        self._watcher = watcher
        self._commands = watcher.node.create_publisher(Float64, "voltage_command", 10)
        watcher.node.create_subscription(JointState, "joint_states", self._answer, 10)
        watcher.node.create_subscription(DiagnosticArray, "/diagnostics", self._note, 100)
        self.reports: dict[str, list[Any]] = {}
        self.samples = 0

    def _answer(self, sample: JointState) -> None:
        self.samples += 1
        stamp = sample.header.stamp
        self._commands.publish(Float64(data=voltage(stamp.sec % 1000 + 1e-9 * stamp.nanosec)))

    def _note(self, array: DiagnosticArray) -> None:
        for status in array.status:
            self.reports.setdefault(status.name.rpartition("/")[2], []).append(status)

    def says(self, text: str) -> Any:  # noqa: ANN401
        """The first report of the diagnoser from now on with a text in its message."""
        reports = self.reports.setdefault("diagnoser", [])
        seen = len(reports)

        def found() -> list[Any]:
            return [status for status in reports[seen:] if text in status.message]

        self._watcher.until(lambda: bool(found()), text)
        return found()[0]

    def value(self, node: str, key: str) -> str:
        """A value in a node's newest report; empty where there is none."""
        reports = self.reports.get(node, [])
        values = {entry.key: entry.value for entry in reports[-1].values} if reports else {}
        return str(values.get(key, ""))

    def plant_rates(self) -> list[float]:
        """The sample rates, Hz, that the plant has reported; not those of its first second."""
        reports = self.reports["plant_simulator"]
        found = [{entry.key: entry.value for entry in report.values} for report in reports]
        return [float(values["rate, Hz"]) for values in found[1:]]

    def diagnose(self) -> Any:  # noqa: ANN401
        """The answer of the service."""
        return self._watcher.call(Trigger, SERVICE, Trigger.Request())


@pytest.fixture
def bench(watcher: Watcher) -> Bench:
    return Bench(watcher)


def test_a_model_that_holds_no_more_is_noticed_and_diagnosed(
    start: Start, watcher: Watcher, bench: Bench, tmp_path: Path
) -> None:
    rig = nominal_model().with_link("transport_delay", delay=DELAY)
    save_model(rig, tmp_path / "rig.yaml")
    gaps = watcher.messages(Float64, "gap")
    floors = watcher.messages(Float64, "noise_floor")
    diagnoser = start("diagnoser", sample_rate=RATE, gap_window=1.0, window=5.0, out="found")
    plant = start("plant_simulator", sample_rate=RATE)
    status = bench.says("the model holds: gap 1")
    assert status.level == b"\0"
    # A report and the numbers beside it come by ways of their own.
    watcher.until(lambda: bool(gaps and floors), "the gap and the noise floor")
    assert gaps[-1].data == pytest.approx(NOISE, rel=0.3)
    assert floors[-1].data == pytest.approx(NOISE, rel=0.3)
    assert plant.stop() == 0

    bench.reports.pop("plant_simulator", None)
    bench.samples = 0
    start("plant_simulator", sample_rate=RATE, model_file="rig.yaml")
    status = bench.says("the model no longer holds: gap ")
    assert status.level == b"\1"
    watcher.until(lambda: gaps[-1].data > 2.0 * floors[-1].data, "a gap above the noise")
    # Where the new rig is quick to start, those of the old one are among the samples that are kept.
    watcher.until(lambda: bench.samples > 5.5 * RATE, "enough samples of the new rig")
    kept = "kept for a diagnosis, s"
    watcher.until(lambda: float(bench.value("diagnoser", kept) or 0) > 4.9, "the report on them")

    before = bench.plant_rates()
    answer = bench.diagnose()
    assert answer.success
    assert re.match(r"diagnosing (4\.9|5\.0) s of joint_states", answer.message)
    again = bench.diagnose()
    assert not again.success
    assert "a diagnosis is running" in again.message
    watcher.until(lambda: "done: " in bench.value("diagnoser", "diagnosis"), "the diagnosis")

    said = bench.value("diagnoser", "diagnosis")
    assert "The rig answers late" in said
    assert said in diagnoser.log
    found = json.loads((tmp_path / "found" / "diagnosis.json").read_text(encoding="utf-8"))
    assert found["effects"] == ["transport_delay"]
    assert (tmp_path / "found" / "report.html").is_file()
    recording = read_recording(tmp_path / "found" / "recording.csv")
    assert recording.duration == pytest.approx(5.0, abs=0.1)
    model = load_model(tmp_path / "found" / "model.yaml")
    # A held voltage tells fractions of a sample apart only where the plant is slow.
    assert DELAY - 1e-4 < model.value("transport_delay", "delay") < DELAY + 1.0 / RATE
    during = bench.plant_rates()[len(before) :]
    assert np.median(during) == pytest.approx(np.median(before), rel=0.1)

    # With the model that was found there is no gap any more.
    file = RosParameter("model_file", value=str(tmp_path / "found" / "model.yaml"))
    request = SetParameters.Request(parameters=[file.to_parameter_msg()])
    (result,) = watcher.call(SetParameters, "diagnoser/set_parameters", request).results
    assert result.successful
    assert bench.says("the model holds: gap 1").level == b"\0"
    assert diagnoser.stop() == 0


def feed(watcher: Watcher, seconds: float) -> None:
    """Samples of a rig that follows no model, all at once."""
    samples = watcher.publisher(JointState, "joint_states")
    for tick in range(round(seconds * RATE)):
        sample = JointState(name=["finger"], position=[1e-9 * tick], effort=[voltage(tick / RATE)])
        sample.header.stamp.sec, rest = divmod(tick, RATE)
        sample.header.stamp.nanosec = rest * 10**9 // RATE
        samples.publish(sample)


def children(process: int) -> list[int]:
    """The processes that one has started."""
    text = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="ascii")
    return [int(word) for word in text.split()]


def test_a_running_diagnosis_ends_with_the_node(
    start: Start, watcher: Watcher, bench: Bench, tmp_path: Path
) -> None:
    diagnoser = start("diagnoser", sample_rate=RATE, out="found")
    status = bench.says("waiting for joint_states")
    assert status.level == b"\3"
    answer = bench.diagnose()
    assert not answer.success
    assert answer.message == "0.0 s of joint_states so far; at least 2 s are needed"

    feed(watcher, 3.0)
    watcher.until(lambda: bench.value("diagnoser", "samples") == str(3 * RATE), "the samples")
    assert bench.diagnose().success
    (job,) = children(diagnoser.process.pid)
    assert diagnoser.stop(signal.SIGTERM) == 0
    assert not Path(f"/proc/{job}").exists()
    assert not (tmp_path / "found" / "diagnosis.json").exists()


def test_what_stands_in_the_way_of_a_diagnosis_is_reported(
    start: Start, watcher: Watcher, bench: Bench, tmp_path: Path
) -> None:
    save_model(nominal_model(), tmp_path / "model.yaml")
    start("diagnoser", sample_rate=RATE, out="found", model_file="model.yaml")
    bench.says("waiting for joint_states")
    feed(watcher, 3.0)
    assert bench.says("no joint_states").level == b"\3"
    (tmp_path / "model.yaml").unlink()
    assert bench.diagnose().success
    watcher.until(lambda: "failed" in bench.value("diagnoser", "diagnosis"), "the failure")
    said = bench.value("diagnoser", "diagnosis")
    reason = f"{tmp_path}/model.yaml: cannot be read: No such file or directory"
    assert said == f"failed: microgripper: {reason}"
