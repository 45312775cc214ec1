"""Identifies the model from recordings, writes it, and can hand it to a running controller.

It does this once and ends. The controller is given the file's name, as its parameter `model_file`,
and reads it itself: both have to see the same file system.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from threading import Thread

from rclpy.parameter import Parameter as RosParameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future as Answer

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import check_place
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.recording import Recording, refuse_twice
from microgripper_control.effects.registry import registry
from microgripper_control.identification.fit import Fit, fit
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.nodes.health import Health
from microgripper_control.nodes.parameters import (
    MODEL_FILE,
    MODEL_FILE_TEXT,
    declare_number,
    declare_path,
    declare_text,
    declare_texts,
    expanded,
    model_path,
)
from microgripper_control.nodes.shell import POLL, Shell, run
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model, save_model
from microgripper_control.plant.simulate import Initial
from microgripper_control.recordings.read import read_recording

TIMEOUT = Parameter("timeout", "s", 10.0, 0.1, 3600.0, "longest wait for the controller")


class Identifier(Shell):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("identifier")
        names = declare_texts(self, "recordings", [], "bags or CSV files of the rig")
        self._recordings = [expanded("recordings", name) for name in names]
        self._model = declare_text(self, "model_file", MODEL_FILE, MODEL_FILE_TEXT, read_only=True)
        self._out = declare_path(self, "out", "identified.yaml", "file to write")
        self._hold = declare_text(
            self,
            "hold",
            Hold.ZERO.value,
            "how the voltage runs between its samples",
            choices=[hold.value for hold in Hold],
            read_only=True,
        )
        self._initial = declare_text(
            self,
            "initial",
            Initial.FIRST_SAMPLE.value,
            "the state that the recordings start in",
            choices=[initial.value for initial in Initial],
            read_only=True,
        )
        self._controller = declare_text(
            self, "controller", "", "name of the node to hand the result to", read_only=True
        )
        self._timeout = declare_number(self, TIMEOUT, read_only=True)
        self._fit: Future[Fit] = Future()
        self._stage = "reading"
        self._written = False
        self._client: AsyncParameterClient | None = None
        self._answer: Answer | None = None
        self._deadline = 0.0

    def begin(self) -> None:
        """Read, and begin to identify."""
        if not self._recordings:
            raise MicrogripperError("recordings is empty; name bags, -p recordings:=[PATH]")
        log = self.get_logger()
        file = model_path(self._model)
        check_place(self._out, [*self._recordings, file])
        model = load_model(file)
        for warning in model.warnings:
            log.warning(warning)
        recordings = [read_recording(path) for path in self._recordings]
        refuse_twice(recordings)
        for recording in recordings:
            for warning in (*recording.warnings, model.beyond(recording.voltage)):
                if warning:
                    log.warning(f"{recording.name}: {warning}")
        Thread(target=self._identify, args=(model, recordings), daemon=True).start()

    def _identify(self, model: Model, recordings: Sequence[Recording]) -> None:
        """In a thread, so that a signal ends the node meanwhile, and its health is reported."""
        conditions = Conditions(Hold(self._hold), Initial(self._initial))
        try:
            self._fit.set_result(fit(model, recordings, conditions, self._at))
        except Exception as error:  # raised where the result is asked for
            self._fit.set_exception(error)

    def _at(self, stage: str) -> None:
        self._stage = f"identifying: {stage}"
        self.get_logger().info(self._stage)

    def work(self, now: float) -> float:
        """As `Shell` says: write the result, and hand it over."""
        if not self._fit.done():
            return POLL
        if not self._written:
            self._write(self._fit.result())
        elif self._client is None:
            self._client = AsyncParameterClient(self, self._controller)
            self._deadline = now + self._timeout
        elif self._answer is None and self._client.services_are_ready():
            file = RosParameter("model_file", RosParameter.Type.STRING, str(self._out.resolve()))
            self._answer = self._client.set_parameters_atomically([file])
        elif self._answer is not None and self._answer.done():
            self._conclude(self._answer)
        elif now > self._deadline:
            self.fail(f"{self._controller} did not answer within {self._timeout:g} s")
        return POLL

    def _write(self, found: Fit) -> None:
        save_model(found.model, self._out)
        self._written = True
        for line in (*summary(found), f"written: {self._out}"):
            self.get_logger().info(line)
        self._stage = f"handing the result to {self._controller}"
        if not self._controller:
            self.finish("done")

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        return Health(self._stage)

    def _conclude(self, answer: Answer) -> None:
        result = answer.result().result
        if result.successful:
            self.finish(f"{self._controller} works with {self._out} now")
        else:
            self.fail(f"{self._controller} refused {self._out}: {result.reason}")


def summary(found: Fit) -> list[str]:
    """What was identified, and what could not be, in lines."""
    lines = [_line("gain d k/(k + k_s)", found.gain.value, found.gain.interval, "m/V")]
    for link, name in found.determined:
        setting = found.model.settings[link][name]
        unit = registry()[link].parameter(name).unit
        lines.append(_line(f"{link}.{name}", setting.value, setting.interval, unit))
    for entry in found.undetermined:
        lines.append(f"{'.'.join(entry.key)} is not determined: {entry.reason}")
    for name, rmse, share in zip(found.recordings, found.rmse, found.relative_rmse, strict=True):
        lines.append(f"{name}: error {1e9 * rmse:.1f} nm rms, {share:.3%} of peak to peak")
    return lines


def _line(title: str, value: float, interval: tuple[float, float] | None, unit: str) -> str:
    low, high = interval or (float("nan"), float("nan"))
    return f"{title} = {value:.6g} {unit} (95 %: {low:.6g} .. {high:.6g})"


def main() -> None:
    """Run the node."""
    run(Identifier)


if __name__ == "__main__":
    main()
