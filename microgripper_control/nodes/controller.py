"""The controller as a node: answers each sample of the plant with one voltage command.

The answer to sample k is applied from tick k+1 on, whenever within the tick it comes. So there is
time for the setpoint that `reference` publishes for the same sample: where setpoints come once a
sample, the answer waits for it, in wall time no longer than `setpoint_wait`. In lockstep it waits
until it is there, and a setpoint that does not come ends the run with an error.

On deactivation, at the end, and while nothing fresh is heard from the plant, the voltage is brought
to `safe_voltage` at `ramp_rate`; not in lockstep, where nobody takes samples any more.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

from rclpy.parameter import Parameter as RosParameter
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.nodes import controller_settings, topics
from microgripper_control.nodes.applied_watch import AppliedWatch
from microgripper_control.nodes.controller_health import Statistics
from microgripper_control.nodes.controller_settings import (
    APPLY_TIMEOUT,
    APPLY_TOLERANCE,
    FEEDBACK_TIMEOUT,
    GAINS,
    LIVE,
    NAMES,
    ControllerSettings,
)
from microgripper_control.nodes.exchange import Exchange
from microgripper_control.nodes.feedback_watch import FeedbackWatch
from microgripper_control.nodes.health import Health
from microgripper_control.nodes.managed import ManagedShell
from microgripper_control.nodes.pairing import Pairing
from microgripper_control.nodes.parameters import follow_changes, model_path
from microgripper_control.nodes.rivals import Rivals
from microgripper_control.nodes.shell import POLL, run
from microgripper_control.nodes.voltage_output import VoltageOutput
from microgripper_control.plant.model_file import load_model


class ControllerNode(ManagedShell):
    """See the module."""

    live = LIVE

    def __init__(self) -> None:
        super().__init__("controller")
        controller_settings.declare(self)
        given = controller_settings.given_gains(self)
        self._settings = ControllerSettings.of(self._values(NAMES), given)
        self._showing = False
        self._show_gains()
        self._controller: Controller | None = None
        self._samples = topics.Newest(self, topics.JOINT_STATES, self._on_sample)
        self._setpoints = {
            topics.SETPOINT: topics.Newest(self, topics.SETPOINT, self._on_setpoint),
            topics.VOLTAGE_SETPOINT: topics.Newest(
                self, topics.VOLTAGE_SETPOINT, self._on_voltage_setpoint
            ),
        }
        self._rivals = {
            topic: Rivals(self, topic) for topic in (topics.VOLTAGE_COMMAND, *self._setpoints)
        }
        follow_changes(self, NAMES, self._checked, self._apply)

    def configure(self) -> None:
        """Compile, then offer the topics."""
        self._settings = ControllerSettings.of(self._values(NAMES), self._settings.given)
        self._show_gains()
        self._settings.compile()
        self._controller = self._settings.controller()
        model = load_model(model_path(self.value_of("model_file")))
        left = ", ".join(model.beside_the_inverse)
        beside = f"model_file: not in the feedforward, left to the PID: {left}" if left else ""
        for warning in (*model.warnings, self._settings.warning, beside):
            if warning:
                self.get_logger().warning(warning)
        self._output = VoltageOutput(self, self._settings.sample_period)

    def cleanup(self) -> None:
        """Withdraw the topics."""
        self._controller = None
        self._output.close()

    def activate(self) -> None:
        """Begin to take samples, in lockstep once the plant takes the answers."""
        period = self._settings.sample_period
        self._lockstep = self.value_of("lockstep")
        timeout = self.value_of(FEEDBACK_TIMEOUT.name)
        if not self._lockstep and timeout < 2.0 * period:
            raise MicrogripperError(
                f"feedback_timeout = {timeout:g} s is less than two samples at "
                f"sample_rate = {1.0 / period:g} Hz; give at least {2.0 * period:g}"
            )
        self._awaits = self._lockstep and self.value_of("await_setpoint")
        patience = self.value_of("setpoint_wait") * period
        if self._lockstep:
            patience = self.value_of("lockstep_timeout")
        self._pairing = Pairing(patience, lockstep=self._lockstep, awaits=self._awaits)
        assert self._controller is not None
        self._controller.forget_counts()
        self._exchange = Exchange(
            self._controller,
            self._output,
            FeedbackWatch(timeout, period),
            AppliedWatch(self.value_of(APPLY_TIMEOUT.name), self.value_of(APPLY_TOLERANCE.name)),
            sample_period=period,
            lockstep=self._lockstep,
        )
        self._intake = controller_settings.make_intake(self)
        self._statistics = Statistics(self._exchange, self._intake, self._rivals)
        if not self._awaits:
            self._open_setpoints()
        if not self._lockstep:
            self._samples.open(reliable=False)

    def deactivate(self) -> None:
        """Bring the voltage down."""
        for subscription in (*self._setpoints.values(), self._samples):
            subscription.close()
        self._exchange.end()

    def work(self, now: float) -> float:
        """As `Shell` says."""
        if not self.active:
            return POLL
        if not self._samples.is_open:
            self._join()
        if now >= self._pairing.deadline:
            if self._lockstep:
                self.fail(f"lockstep: no {self._setpoint_topic} came for a sample")
                return 0.0
            self._statistics.late += 1
            self._answer_sample()
        if not self._lockstep:
            self._intake.look(now)
            if self._exchange.feedback.is_lost(now):
                self._pairing.drop()
                return self._exchange.descend(now)
        wait = min(self._pairing.deadline - time.monotonic(), self._exchange.feedback.left)
        return max(0.0, min(wait, self._intake.left))

    def _join(self) -> None:
        """In lockstep: take samples once all others are there and have been told of."""
        for subscription in self._setpoints.values():
            subscription.open(if_published=True)
        if not self._missing():
            self._samples.open(if_published=True)
        if self._samples.is_open:
            self._open_setpoints()

    def _missing(self) -> list[str]:
        missing = topics.missing_partners(self, self._output.publisher, self.value_of("partners"))
        if self._awaits and not any(one.is_open for one in self._setpoints.values()):
            missing.append("a publisher of setpoints")
        return missing

    def _open_setpoints(self) -> None:
        for subscription in self._setpoints.values():
            subscription.open()

    def _on_sample(self, message: JointState) -> None:
        if not self.active or self._controller is None:
            return
        now = time.monotonic()
        displacement, voltage = topics.finger(message)
        if not self._exchange.meets(topics.stamp_of(message), displacement, voltage, now):
            return
        if self._pairing.waiting:
            self._answer_sample()
        if self._pairing.sample(displacement, voltage, now):
            self._answer_sample()

    def _on_setpoint(self, message: Float64) -> None:
        if self._settings.mode is not Mode.OPEN_LOOP:
            self._take_command(message.data)

    def _on_voltage_setpoint(self, message: Float64) -> None:
        if self._settings.mode is Mode.OPEN_LOOP:
            self._take_command(message.data)

    def _take_command(self, command: float) -> None:
        if not self.active or self._controller is None:
            return
        limits = self._settings.limits
        is_voltage = self._settings.mode is Mode.OPEN_LOOP
        reach = (limits.low, limits.high) if is_voltage else self._controller.reach
        was_returning = self._intake.returns
        taken = self._intake.take(command, reach, time.monotonic())
        if was_returning and not self._intake.returns:
            self._exchange.returned()
        if self._pairing.setpoint(taken):
            self._answer_sample()
        if self._lockstep and self._pairing.surplus:
            self.fail("lockstep: two setpoints for one sample; is there a second publisher?")

    def _answer_sample(self) -> None:
        paired = self._pairing.take()
        if self._exchange.answer(paired, returns=self._intake.returns):
            self._statistics.note(paired)

    def _checked(self, changes: dict[str, Any]) -> ControllerSettings:
        known = None if "model_file" in changes else self._settings.identified
        given = self._settings.given
        if not self._showing:
            given |= GAINS & changes.keys()
        return ControllerSettings.of({**self._values(NAMES), **changes}, given, known)

    def _show_gains(self) -> None:
        """Have the parameters say which gains are at work, without counting them as given."""
        at_work = {name: getattr(self._settings.gains, name) for name in GAINS}
        shown = [
            RosParameter(name, RosParameter.Type.DOUBLE, gain)
            for name, gain in at_work.items()
            if gain != self.value_of(name)
        ]
        self._showing = True
        if shown:
            self.set_parameters_atomically(shown)
        self._showing = False

    def _apply(self, settings: ControllerSettings) -> None:
        if self._controller is not None:
            settings.change(self._controller, self._settings)
        if self.active and settings.mode is not self._settings.mode:
            self._pairing.forget_setpoint()
            self._statistics.forget_setpoint()
        if settings.warning and settings.warning != self._settings.warning:
            self.get_logger().warning(settings.warning)
        self._settings = settings
        self._show_gains()

    @property
    def _setpoint_topic(self) -> str:
        open_loop = self._settings.mode is Mode.OPEN_LOOP
        return topics.VOLTAGE_SETPOINT if open_loop else topics.SETPOINT

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        if not self.active or self._controller is None:
            return Health("not active")
        if not self._samples.is_open:
            missing = self._missing() or [topics.JOINT_STATES]
            return Health("lockstep: waiting for " + ", ".join(missing))
        return self._statistics.health(self._controller, elapsed, self._settings.warning)

    def _values(self, names: Iterable[str]) -> dict[str, Any]:
        return {name: self.value_of(name) for name in names}


def main() -> None:
    """Run the node."""
    run(ControllerNode)


if __name__ == "__main__":
    main()
