from __future__ import annotations

import math
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter as RosParameter
from running_nodes import Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.model_file import save_model
from microgripper_control.plant.rig import Rig

pytestmark = pytest.mark.ros

GAIN = 1.42e-7  # m/V, about


def stamp_now(state: JointState) -> None:
    state.header.stamp.sec, state.header.stamp.nanosec = divmod(time.monotonic_ns(), 10**9)


class Loop:
    """The test in the plant's place: sends samples and gets the answers, one by one."""

    def __init__(self, start: Start, watcher: Watcher, **settings: object) -> None:
        self.watcher = watcher
        self.answers = watcher.messages(Float64, "voltage_command")
        self.node = start("controller", setpoint_wait=0, **settings)
        self.states = watcher.publisher(JointState, "joint_states")
        self.setpoints = watcher.publisher(Float64, "setpoint")
        watcher.published("voltage_command")
        self.tick = 0

    def answer(self, position: float, voltage: float) -> float:
        """The controller's answer to one sample.

        It takes samples as they come, best effort: one from before it knew of this publisher is
        gone, so it is sent again.
        """
        state = JointState(name=["finger"], position=[position], effort=[voltage])
        self.tick += 1
        count = len(self.answers)
        resend = 0.0

        def answered() -> bool:
            nonlocal resend
            if len(self.answers) == count and time.monotonic() > resend:
                stamp_now(state)
                self.states.publish(state)
                resend = time.monotonic() + 1.0
            return len(self.answers) > count

        self.watcher.until(answered, "an answer")
        return float(self.answers[-1].data)

    def ask(self, setpoint: float) -> None:
        """Set a setpoint; the samples that follow prove that it came."""
        self.setpoints.publish(Float64(data=setpoint))

    def set(self, name: str, value: object) -> str:
        """Set a parameter; the reason why not."""
        kind = RosParameter.Type.from_parameter_value(value)
        request = SetParameters.Request(
            parameters=[RosParameter(name, kind, value).to_parameter_msg()]
        )
        (result,) = self.watcher.call(SetParameters, "controller/set_parameters", request).results
        assert result.successful == (not result.reason)
        return str(result.reason)

    def get(self, name: str) -> Any:  # noqa: ANN401
        request = GetParameters.Request(names=[name])
        (value,) = self.watcher.call(GetParameters, "controller/get_parameters", request).values
        return RosParameter.from_parameter_msg(Parameter(name=name, value=value)).value

    def run(self, rig: Rig, ticks: int) -> float:
        """Close the loop over a rig; the last displacement."""
        for _ in range(ticks):
            rig.tick()
            rig.command(self.answer(rig.position, rig.voltage))
        return rig.position


def test_one_answer_for_each_sample_from_a_bumpless_start_on(
    start: Start, watcher: Watcher
) -> None:
    loop = Loop(start, watcher)
    # Nothing is known of a plant that reports no voltage: nothing is said.
    loop.states.publish(JointState(name=["finger"], position=[0.0]))
    assert [loop.answer(0.0, 33.0) for _ in range(3)] == [33.0] * 3
    # Wild samples and setpoints change nothing.
    assert loop.answer(math.nan, 33.0) == 33.0
    assert loop.answer(math.inf, math.nan) == 33.0
    loop.ask(math.nan)
    assert loop.answer(0.0, 33.0) == 33.0
    assert loop.answer(33.0 * GAIN, 33.0) == 33.0
    assert len(loop.answers) == loop.tick
    assert loop.node.stop() == 0


def test_it_brings_the_plant_to_the_setpoint_in_every_mode(start: Start, watcher: Watcher) -> None:
    # No sample comes while a parameter is set: that is not to count as the plant's loss.
    loop = Loop(start, watcher, mode="pid", feedback_timeout=5.0)
    rig = Rig(nominal_model(), 1e-3)
    loop.run(rig, 2)
    for goal, mode in ((5e-6, "pid"), (8e-6, "feedforward"), (6e-6, "cascade")):
        assert loop.set("mode", mode) == ""
        before = rig.voltage
        loop.ask(goal)
        loop.run(rig, 1)
        assert abs(rig.voltage - before) <= 20.0 + 1e-9  # the rate limit: 2e4 V/s
        assert loop.run(rig, 300) == pytest.approx(goal, abs=0.01e-6)
    # In open loop the command is a voltage, of a topic of its own: the setpoint counts no more.
    voltages = watcher.publisher(Float64, "voltage_setpoint")
    assert loop.set("mode", "open_loop") == ""
    held = rig.voltage
    loop.ask(2e-6)
    loop.run(rig, 10)
    assert rig.voltage == held
    voltages.publish(Float64(data=70.0))
    watcher.until(lambda: loop.run(rig, 20) is not None and rig.voltage == 70.0, "70 V")
    voltages.publish(Float64(data=1e9))
    watcher.until(lambda: loop.run(rig, 20) is not None and rig.voltage == 160.0, "160 V")


def test_a_voltage_that_was_not_taken_is_no_displacement(start: Start, watcher: Watcher) -> None:
    """20 V that came after the last sample of the open loop is not 20 m in the next mode."""
    loop = Loop(start, watcher, mode="open_loop", feedback_timeout=5.0)
    rig = Rig(nominal_model(), 1e-3)
    voltages = watcher.publisher(Float64, "voltage_setpoint")

    def arrived() -> bool:
        voltages.publish(Float64(data=20.0))
        loop.run(rig, 20)
        return rig.voltage == 20.0

    watcher.until(arrived, "20 V")
    voltages.publish(Float64(data=20.0))
    time.sleep(0.1)  # it has come, and no sample takes it
    assert loop.set("mode", "cascade") == ""
    loop.run(rig, 30)
    assert rig.voltage == 20.0


def test_the_parameters_of_a_running_controller(
    start: Start, watcher: Watcher, tmp_path: Path
) -> None:
    loop = Loop(start, watcher, kp=5, voltage_max=150)
    assert (loop.get("kp"), type(loop.get("kp"))) == (5.0, float)
    assert loop.set("kp", 7) == ""
    assert loop.get("kp") == 7.0
    # Refused, with the reason.
    assert "kp" in loop.set("kp", -1.0)
    assert "kp" in loop.set("kp", math.nan)
    assert "none of open_loop, feedforward, pid, cascade" in loop.set("mode", "sideways")
    assert "configure" in loop.set("voltage_max", 100.0)
    assert "nowhere.yaml" in loop.set("model_file", "nowhere.yaml")
    assert loop.get("kp") == 7.0
    # All or nothing.
    values = {"kp": 9.0, "ki": -1.0}
    request = SetParametersAtomically.Request(
        parameters=[
            Parameter(name=name, value=ParameterValue(type=3, double_value=value))
            for name, value in values.items()
        ]
    )
    answer = watcher.call(SetParametersAtomically, "controller/set_parameters_atomically", request)
    assert not answer.result.successful
    assert loop.get("kp") == 7.0
    # Identified values come as a file; those that do not allow the limits are refused.
    narrow = tmp_path / "narrow.yaml"
    save_model(nominal_model(), narrow)
    narrow.write_text(narrow.read_text().replace("high: 160.0", "high: 100.0"))
    assert "exceed the model's voltage range" in loop.set("model_file", str(narrow))
    other = tmp_path / "other.yaml"
    save_model(nominal_model().with_values({("bouc_wen", "d"): 2e-7}), other)
    assert loop.set("mode", "feedforward") == ""
    assert loop.answer(0.0, 0.0) == 0.0
    assert loop.set("model_file", str(other)) == ""
    loop.ask(5e-6)
    while loop.answers[-1].data == 0.0:
        loop.answer(0.0, 0.0)
    for _ in range(30):  # the difference between the models fades at the ramp rate
        answer = loop.answer(0.0, loop.answers[-1].data)
    assert answer == pytest.approx(5e-6 / (GAIN * 2e-7 / 1.4447e-7), rel=0.1)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_in_the_end_the_voltage_is_brought_down(
    hangup: None, start: Start, watcher: Watcher, number: int
) -> None:
    loop = Loop(start, watcher, mode="open_loop", ramp_rate=1000, safe_voltage=10)
    loop.answer(0.0, 0.0)
    watcher.publisher(Float64, "voltage_setpoint").publish(Float64(data=100.0))
    while loop.answers[-1].data < 100.0:
        loop.answer(0.0, loop.answers[-1].data)
    del loop.answers[:]
    assert loop.node.stop(number) == 0
    watcher.until(lambda: len(loop.answers) >= 92, "the whole ramp")
    ramp = np.array([100.0, *(answer.data for answer in loop.answers)])
    np.testing.assert_allclose(np.diff(ramp)[:90], -1.0)
    assert set(ramp[90:]) == {10.0}


def test_deactivated_by_a_supervisor_it_brings_the_voltage_down(
    start: Start, watcher: Watcher
) -> None:
    loop = Loop(start, watcher, mode="pid")
    rig = Rig(nominal_model(), 1e-3)
    loop.run(rig, 1)
    loop.ask(5e-6)
    loop.run(rig, 50)
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_DEACTIVATE))
    assert watcher.call(ChangeState, "controller/change_state", request).success
    watcher.until(lambda: loop.answers[-1].data == 0.0, "0 V")
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_ACTIVATE))
    assert watcher.call(ChangeState, "controller/change_state", request).success
    watcher.until(lambda: loop.states.get_subscription_count() > 0, "it to listen again")
    rig.command(0.0)
    rig.tick()
    assert loop.answer(rig.position, 0.0) == 0.0


def test_its_health_tells_of_what_is_wrong(start: Start, watcher: Watcher) -> None:
    reports = watcher.messages(DiagnosticArray, "/diagnostics")
    loop = Loop(start, watcher, sample_rate=50)  # a watcher looks no faster

    def told(message: str) -> bool:
        return bool(reports) and reports[-1].status[0].message == message

    watcher.until(lambda: told("waiting for joint_states"), "the first state")
    loop.answer(0.0, 0.0)
    watcher.until(
        lambda: loop.answer(0.0, 0.0) is not None and told("waiting for a setpoint"), "the next"
    )
    loop.ask(1.0)
    wrong = "setpoints not finite or out of reach"
    watcher.until(
        lambda: loop.answer(0.0, loop.answers[-1].data) is not None and told(wrong), "what is wrong"
    )
    watcher.until(lambda: told("feedback lost: none comes; safe voltage"), "the loss of the plant")


def test_a_plant_of_another_rate_is_told(start: Start, watcher: Watcher) -> None:
    """Gains, margins and the dead time in samples are for a loop that is not there."""
    reports = watcher.messages(DiagnosticArray, "/diagnostics")
    node = start("controller", sample_rate=1000)
    start("plant_simulator", sample_rate=100)
    wrong = "the plant's rate is not sample_rate"

    def told() -> bool:
        last = reports[-1].status[0] if reports else None
        if last is None or wrong not in last.message:
            return False
        rate = next(one.value for one in last.values if one.key == "rate by the stamps, Hz")
        return last.level == b"\1" and float(rate) == pytest.approx(100.0, rel=0.02)

    watcher.until(told, "what is wrong")
    assert node.stop() == 0


def test_what_the_model_has_beside_its_inverse_is_told(start: Start, tmp_path: Path) -> None:
    rig = nominal_model().with_link("saturation", high=80.0).with_link("sensor_zero", offset=1e-6)
    save_model(rig.with_link("amplifier_lag"), tmp_path / "rig.yaml")
    node = start("controller", model_file=str(tmp_path / "rig.yaml"))
    node.until_it_says("not in the feedforward, left to the PID: saturation")
    assert node.stop() == 0


def test_a_change_of_state_that_is_none_is_refused_and_the_loop_goes_on(
    start: Start, watcher: Watcher
) -> None:
    loop = Loop(start, watcher, mode="pid")
    assert loop.answer(0.0, 0.0) == 0.0
    for impossible in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
        request = ChangeState.Request(transition=Transition(id=impossible))
        assert not watcher.call(ChangeState, "controller/change_state", request).success
    assert loop.answer(0.0, 0.0) == 0.0
    assert loop.node.stop() == 0


def test_a_sample_rate_too_slow_for_the_feedback_timeout_is_refused(start: Start) -> None:
    node = start("controller", sample_rate=10)
    assert node.ended() == 2
    assert "feedback_timeout = 0.06 s is less than two samples at sample_rate = 10 Hz" in node.log
    assert "give at least 0.2" in node.log


def test_gains_of_ones_own_for_a_model_that_none_suit(start: Start, tmp_path: Path) -> None:
    values = {("second_order", "m"): 0.05, ("second_order", "b"): 0.0}
    undamped = nominal_model().with_values(values)
    save_model(undamped, tmp_path / "undamped.yaml")
    refused = start("controller", model_file=str(tmp_path / "undamped.yaml"))
    assert refused.ended() == 2
    assert "give gains" in refused.log
    node = start("controller", model_file=str(tmp_path / "undamped.yaml"), ki=1e6)
    node.until_it_says("ready")
    assert node.stop() == 0
