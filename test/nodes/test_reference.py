from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from running_nodes import Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.control.setpoints import Sine, Triangle
from microgripper_control.nodes.new_time import AGREE

pytestmark = pytest.mark.ros

T = 0.001


class Samples:
    """The test in the place of plant and controller."""

    def __init__(self, watcher: Watcher, topic: str) -> None:
        self.watcher = watcher
        self.setpoints = watcher.messages(Float64, topic)
        self.states = watcher.publisher(JointState, "joint_states")

    def send(self, tick: int) -> float:
        """The setpoint that answers the sample of a tick."""
        nanoseconds = 5_000_000_000 + tick * 1_000_000
        state = JointState(name=["finger"], position=[0.0], effort=[0.0])
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(nanoseconds, 10**9)
        count = len(self.setpoints)
        self.states.publish(state)
        self.watcher.until(lambda: len(self.setpoints) > count, "a setpoint")
        return float(self.setpoints[-1].data)


def test_a_setpoint_for_each_sample_by_its_stamp(start: Start, watcher: Watcher) -> None:
    wave = {"low": 2e-6, "high": 12e-6, "frequency": 50.0}
    node = start("reference", partners=["watcher"], shape="sine", **wave)
    samples = Samples(watcher, "setpoint")
    ticks = [0, 1, 2, 7, 8, 100]
    wanted = Sine(**wave).samples(101, T)[ticks]
    np.testing.assert_array_equal([samples.send(tick) for tick in ticks], wanted)
    # A sample that was overtaken, or from another time, changes nothing.
    assert [samples.send(tick) for tick in (99, 3_600_000)] == [wanted[-1]] * 2
    # Time that runs backwards is a new beginning, once several samples agree.
    again = [samples.send(tick) for tick in range(3, 3 + AGREE + 1)]
    assert again[: AGREE - 1] == [wanted[-1]] * (AGREE - 1)
    np.testing.assert_array_equal(again[AGREE - 1 :], Sine(**wave).samples(AGREE + 1, T)[-2:])
    assert node.stop() == 0


def test_segments_one_after_the_other_and_the_end(start: Start, watcher: Watcher) -> None:
    settings = {
        "segments": ["up", "wave"],
        "up.shape": "triangle",
        "up.length": 0.01,
        "up.high": 5,
        "up.frequency": 50,
        "wave.shape": "sine",
        "wave.length": 0.02,
        "wave.high": 80,
        "wave.frequency": 100,
    }
    node = start("reference", partners=["watcher"], quantity="voltage", at_end="stop", **settings)
    samples = Samples(watcher, "voltage_setpoint")
    wanted = [
        *Triangle(high=5, frequency=50).samples(10, T),
        *Sine(high=80, frequency=100).samples(20, T),
    ]
    ticks = [0, 1, 2, 3_600_000, *range(3, 30)]
    wanted.insert(3, wanted[2])  # a wild stamp does not end it
    np.testing.assert_array_equal([samples.send(tick) for tick in ticks], wanted)
    assert node.ended() == 0
    assert "30 setpoints" in node.log


def test_a_csv_is_followed_and_then_held(start: Start, watcher: Watcher, tmp_path: Path) -> None:
    file = tmp_path / "wanted.csv"
    file.write_text("time_s,setpoint_m\n0.0,1e-6\n0.002,3e-6\n0.003,2e-6\n")
    node = start("reference", partners=["watcher"], shape="csv", file=str(file))
    samples = Samples(watcher, "setpoint")
    assert [samples.send(tick) for tick in range(6)] == [1e-6, 1e-6, 3e-6, 2e-6, 2e-6, 2e-6]
    assert node.stop() == 0
