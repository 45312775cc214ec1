"""Watches whether the model still holds, and diagnoses on request what the rig does instead.

The model runs beside the live `joint_states`. The gap between the two over a sliding window and its
noise floor are published; a gap of many noise floors is a warning. The newest samples are kept, and
the service `~/diagnose` (std_srvs/Trigger) has them diagnosed. It answers at once whether that has
begun: a diagnosis takes longer than a caller should be kept waiting. That it is done, and what it
found, stands in `/diagnostics` and in the log. The node takes no part in the control loop.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder
from microgripper_control.core.parameters import Parameter
from microgripper_control.nodes import topics
from microgripper_control.nodes.controller_settings import SAMPLE_RATE
from microgripper_control.nodes.diagnosis_job import DiagnosisJob
from microgripper_control.nodes.health import Health
from microgripper_control.nodes.live_comparison import LiveComparison
from microgripper_control.nodes.pacing import Pace
from microgripper_control.nodes.parameters import (
    MODEL_FILE,
    MODEL_FILE_TEXT,
    declare_number,
    declare_path,
    declare_text,
    follow_changes,
    model_path,
)
from microgripper_control.nodes.shell import Shell, run
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model
from microgripper_control.recordings.csv import write_csv

GAP_WINDOW = Parameter("gap_window", "s", 5.0, 0.1, 600.0, "time over which the gap is taken")
PUBLISH_RATE = Parameter("publish_rate", "Hz", 10.0, 0.1, 100.0, "of gap and noise_floor")
WARN_RATIO = Parameter("warn_ratio", "1", 3.0, 1.0, 1e6, "noise floors; a larger gap is a warning")
LEAST_GAP = Parameter("least_gap", "m", 1e-9, 0.0, 1e-3, "a smaller gap is never a warning")
WINDOW = Parameter("window", "s", 60.0, 2.0, 600.0, "the newest samples, kept for a diagnosis")

TAKE_PERIOD = 0.05  # s
SHORTEST = 2.0  # s of samples for a diagnosis
RECORDING = "recording.csv"  # what was diagnosed, beside the diagnosis


class Diagnoser(Shell):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("diagnoser")
        name = declare_text(self, "model_file", MODEL_FILE, MODEL_FILE_TEXT)
        rate = declare_number(self, SAMPLE_RATE, read_only=True)
        gap_window = declare_number(self, GAP_WINDOW, read_only=True)
        window = declare_number(self, WINDOW, read_only=True)
        publish_rate = declare_number(self, PUBLISH_RATE, read_only=True)
        declare_number(self, WARN_RATIO)
        declare_number(self, LEAST_GAP)
        out = declare_path(self, "out", "diagnosis", "folder for a diagnosis")
        self._out = Path(os.path.realpath(out))
        self._model_file, model = self._checked({"model_file": name})
        self._job: DiagnosisJob | None = None
        self._concluded = "none yet"
        now = time.monotonic()
        self._pace = Pace(1.0 / publish_rate, now)
        self._comparison = LiveComparison(model, rate, gap_window, window, now)
        follow_changes(self, ["model_file"], self._checked, self._apply)
        self._gaps = topics.publish_on(self, topics.GAP)
        self._floors = topics.publish_on(self, topics.NOISE_FLOOR)
        self._samples = topics.Batches(self, topics.JOINT_STATES)
        self.create_service(Trigger, "~/diagnose", self._on_request)

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Those that the executor serves: not that of the samples."""
        taken = self._samples.subscription
        return (one for one in super().subscriptions if one is not taken)

    def work(self, now: float) -> float:
        """As `Shell` says."""
        for message in self._samples.take():
            displacement, voltage = topics.finger(message)
            self._comparison.take(topics.stamp_of(message), voltage, displacement, now)
        if self._pace.due(now):
            self._compare(now)
        if self._job is not None and self._job.is_over:
            self._conclude(self._job)
        return min(TAKE_PERIOD, self._pace.wait(now))

    def leave(self) -> None:
        """End a diagnosis that runs."""
        if self._job is not None:
            self._job.end()

    def _compare(self, now: float) -> None:
        ratio, least = self.value_of(WARN_RATIO.name), self.value_of(LEAST_GAP.name)
        reading = self._comparison.read(ratio, least, now)
        if reading is not None:
            _publish(self._gaps, reading.gap)
            _publish(self._floors, reading.noise_floor)

    def _on_request(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._begin_diagnosis()
        except MicrogripperError as error:
            response.message = str(error)
            return response
        response.success = True
        response.message = (
            f"diagnosing {self._comparison.samples.duration:.1f} s of joint_states; /diagnostics "
            f"says when it is done, the result goes to {self._out}"
        )
        self.get_logger().info(response.message)
        return response

    def _begin_diagnosis(self) -> None:
        """Raises MicrogripperError where there is a reason not to."""
        samples = self._comparison.samples
        if self._job is not None:
            raise MicrogripperError(
                f"a diagnosis is running, for {self._job.running:.0f} s so far; wait for its end"
            )
        if samples.duration < SHORTEST:
            raise MicrogripperError(
                f"{samples.duration:.1f} s of joint_states so far; at least {SHORTEST:g} s are "
                "needed"
            )
        recording = make_folder(self._out) / RECORDING
        write_csv(recording, samples.recording())
        self._job = DiagnosisJob(self._model_file, recording, self._out)

    def _conclude(self, job: DiagnosisJob) -> None:
        self._job = None
        try:
            found = job.finding()
        except MicrogripperError as error:
            self._concluded = f"failed: {error}"
            self.get_logger().error(f"diagnosis {self._concluded}")
            return
        self._concluded = f"done: {found}"
        self.get_logger().info(f"diagnosis {self._concluded} ({job.running:.0f} s, {self._out})")

    def _checked(self, changes: dict[str, Any]) -> tuple[Path, Model]:
        path = model_path(changes["model_file"]).resolve()
        model = load_model(path)
        for warning in model.warnings:
            self.get_logger().warning(warning)
        return path, model

    def _apply(self, given: tuple[Path, Model]) -> None:
        self._model_file, model = given
        self._comparison.use(model)

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        state = self._concluded
        if self._job is not None:
            state = f"running for {self._job.running:.0f} s"
        health = self._comparison.health(time.monotonic())
        return replace(health, values={**health.values, "diagnosis": state})


def _publish(publisher: Publisher, value: float) -> None:
    publisher.publish(Float64(data=value))


def main() -> None:
    """Run the node."""
    run(Diagnoser)


if __name__ == "__main__":
    main()
