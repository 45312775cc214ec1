from __future__ import annotations

import math
import signal
import time
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter as RosParameter
from rosgraph_msgs.msg import Clock
from running_nodes import Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

pytestmark = pytest.mark.ros

PERIOD = 1_000_000  # ns


def stamps(samples: list[Any]) -> np.ndarray:
    return np.array([s.header.stamp.sec * 10**9 + s.header.stamp.nanosec for s in samples])


def test_wall_time(start: Start, watcher: Watcher) -> None:
    samples = watcher.messages(JointState, "joint_states")
    displacements = watcher.messages(Float64, "displacement")
    plant = start("plant_simulator", noise_std=0, command_timeout=0)
    commands = watcher.publisher(Float64, "voltage_command")

    # A command is latched at the next tick and held; the displacement answers one tick later.
    watcher.until(lambda: len(samples) > 10, "samples")
    commands.publish(Float64(data=100.0))
    watcher.until(lambda: samples[-1].effort[0] == 100.0, "the command")
    # What is not a voltage changes nothing, what is too much is clipped.
    for wild in (math.nan, math.inf, -math.inf):
        commands.publish(Float64(data=wild))
    commands.publish(Float64(data=1e300))
    watcher.until(lambda: samples[-1].effort[0] == 160.0, "the clipped command")
    watcher.until(lambda: samples[-3].effort[0] == 160.0, "its answer")
    assert plant.stop(signal.SIGTERM) == 0

    assert samples[0].name == ["finger"]
    assert np.all((np.diff(stamps(samples)) % PERIOD) == 0)
    voltage = np.array([s.effort[0] for s in samples])
    assert set(voltage) == {0.0, 100.0, 160.0}
    position = np.array([s.position[0] for s in samples])
    ticks = (stamps(samples) - stamps(samples)[0]) // PERIOD
    everywhere = voltage[np.searchsorted(ticks, np.arange(ticks[-1] + 1), side="right") - 1]
    # Ticks that were missed held a voltage of either side; judge where it had stood for a while.
    settled = np.flatnonzero(np.convolve(np.abs(np.diff(voltage)), np.ones(5))[: len(voltage)] == 0)
    np.testing.assert_allclose(
        position[settled],
        simulate(nominal_model(), everywhere, 1e-3)[ticks[settled]],
        atol=1e-12,
    )
    velocity = np.array([s.velocity[0] for s in samples])
    neighbours = np.flatnonzero(np.diff(ticks) == 1)
    np.testing.assert_allclose(
        velocity[neighbours + 1],
        (position[neighbours + 1] - position[neighbours]) * 1e3,
        atol=1e-12,
    )
    # Of the two topics one may have been found a little before the other: they end alike.
    watcher.until(
        lambda: bool(displacements) and displacements[-1].data == position[-1],
        "the last displacement",
    )
    both = min(len(displacements), len(samples))
    assert both > 10
    np.testing.assert_array_equal([d.data for d in displacements[-both:]], position[-both:])


def test_lifecycle(start: Start, watcher: Watcher) -> None:
    samples = watcher.messages(JointState, "joint_states")
    reports = watcher.messages(DiagnosticArray, "/diagnostics")
    plant = start("plant_simulator", autostart=False)

    def state() -> int:
        answer = watcher.call(GetState, "plant_simulator/get_state", GetState.Request())
        return int(answer.current_state.id)

    def change(transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return bool(watcher.call(ChangeState, "plant_simulator/change_state", request).success)

    assert state() == State.PRIMARY_STATE_UNCONFIGURED
    assert change(Transition.TRANSITION_CONFIGURE)
    assert state() == State.PRIMARY_STATE_INACTIVE
    assert not samples
    rate = RosParameter("sample_rate", value=500)
    request = SetParameters.Request(parameters=[rate.to_parameter_msg()])
    (result,) = watcher.call(SetParameters, "plant_simulator/set_parameters", request).results
    assert result.reason == "sample_rate is read when the node is configured; clean up first"
    assert change(Transition.TRANSITION_ACTIVATE)
    watcher.until(lambda: len(samples) > 10, "samples")
    assert change(Transition.TRANSITION_DEACTIVATE)
    assert state() == State.PRIMARY_STATE_INACTIVE
    told = len(reports)  # the next may be from before, and samples may be under way
    watcher.until(lambda: len(reports) > told + 1, "its health")
    assert reports[-1].status[0].message == "not active"
    count = len(samples)
    watcher.until(lambda: len(reports) > told + 2, "its health again")
    assert len(samples) == count
    assert change(Transition.TRANSITION_ACTIVATE)
    watcher.until(lambda: len(samples) > count + 10, "more samples")
    assert np.all(np.diff(stamps(samples)) > 0)
    assert change(Transition.TRANSITION_DEACTIVATE)
    assert change(Transition.TRANSITION_CLEANUP)
    assert change(Transition.TRANSITION_CONFIGURE)
    assert change(Transition.TRANSITION_INACTIVE_SHUTDOWN)
    assert state() == State.PRIMARY_STATE_FINALIZED
    assert plant.stop() == 0


def test_health_is_reported(start: Start, watcher: Watcher) -> None:
    reports = watcher.messages(DiagnosticArray, "/diagnostics")
    start("plant_simulator", sample_rate=200)
    commands = watcher.publisher(Float64, "voltage_command")
    watcher.until(lambda: len(reports) > 1, "a report")
    (status,) = reports[-1].status
    assert status.name == "microgripper/plant_simulator"
    values = {entry.key: entry.value for entry in status.values}
    assert values["clock"] == "wall"
    assert int(values["samples"]) > 0

    def complains() -> bool:
        commands.publish(Float64(data=math.nan))
        return bool(reports[-1].status[0].message == "voltage commands refused or out of range")

    watcher.until(complains, "a warning")
    assert reports[-1].status[0].level == b"\1"


def test_lockstep_tells_the_time_and_waits_for_each_answer(start: Start, watcher: Watcher) -> None:
    times = watcher.messages(Clock, "/clock")
    samples = watcher.messages(JointState, "joint_states")
    commands = watcher.node.create_publisher(Float64, "voltage_command", 10)
    plant = start(
        "plant_simulator", lockstep=True, partners=["watcher"], duration=0.02, lockstep_timeout=30
    )
    for tick in range(20):
        watcher.until(lambda tick=tick: len(samples) == tick + 1, f"sample {tick}")
        if tick == 0:  # the plant need not know yet who listens to the time
            watcher.published("/clock")
            time.sleep(0.5)
        assert samples[-1].effort[0] == (0.0 if tick == 0 else 10.0 + tick - 1)
        commands.publish(Float64(data=10.0 + tick))
    assert plant.ended() == 0
    np.testing.assert_array_equal(stamps(samples), PERIOD * np.arange(20))
    watcher.until(lambda: len(times) > 10, "the time")  # each is kept until the next one only
    told = [one.clock.sec * 10**9 + one.clock.nanosec for one in times]
    assert set(told) <= set(PERIOD * np.arange(20))
    assert np.all(np.diff(told) > 0)
    assert "20 samples" in plant.log


def test_a_missing_answer_ends_the_run_with_an_error(start: Start, watcher: Watcher) -> None:
    samples = watcher.messages(JointState, "joint_states")
    commands = watcher.node.create_publisher(Float64, "voltage_command", 10)
    plant = start("plant_simulator", lockstep=True, partners=["watcher"], lockstep_timeout=5)
    watcher.until(lambda: len(samples) == 1, "sample 0")
    commands.publish(Float64(data=1.0))
    watcher.until(lambda: len(samples) == 2, "sample 1")
    assert plant.ended() == 1
    assert "no voltage_command for sample 1" in plant.log


def test_a_second_publisher_ends_the_run_with_an_error(start: Start, watcher: Watcher) -> None:
    """Whatever it sends would pass for an answer, and the run would be another each time."""
    samples = watcher.messages(JointState, "joint_states")
    commands = watcher.node.create_publisher(Float64, "voltage_command", 10)
    plant = start("plant_simulator", lockstep=True, partners=["watcher"], lockstep_timeout=30)
    watcher.until(lambda: len(samples) == 1, "sample 0")
    intruder = watcher.node.create_publisher(Float64, "voltage_command", 10)
    assert plant.ended() == 1
    assert "voltage_command is published by watcher and watcher, not one" in plant.log
    for publisher in (commands, intruder):
        watcher.node.destroy_publisher(publisher)


def test_it_begins_at_rest_at_the_voltage_that_is_asked_for(start: Start, watcher: Watcher) -> None:
    samples = watcher.messages(JointState, "joint_states")
    start("plant_simulator", noise_std=0, command_timeout=0, initial_voltage=120.0)
    watcher.until(lambda: len(samples) > 10, "samples")
    began = np.full(2, 120.0)
    rested = simulate(nominal_model(), began, 1e-3, initial=Initial.FIRST_SAMPLE)[0]
    assert {one.effort[0] for one in samples} == {120.0}
    np.testing.assert_allclose([one.position[0] for one in samples], rested, rtol=1e-12)


def test_a_missing_partner_ends_the_run_with_an_error(start: Start) -> None:
    plant = start("plant_simulator", lockstep=True, startup_timeout=0.3)
    assert plant.ended() == 1
    assert "controller, reference" in plant.log
