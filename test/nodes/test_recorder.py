from __future__ import annotations

import signal
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from running_nodes import PATIENCE, Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, String

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.nodes.recorder import Recorder
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.offered_qos import Offered, offered
from microgripper_control.recordings.read import read_recording

pytestmark = pytest.mark.ros

COUNT = 2000
NUMBERS = np.arange(float(COUNT))


def publish_at_1_khz(watcher: Watcher) -> None:
    """Sample, setpoint and command, numbered, once a millisecond."""
    states = watcher.publisher(JointState, "joint_states")
    setpoints = watcher.publisher(Float64, "setpoint")
    commands = watcher.publisher(Float64, "voltage_command")
    state = JointState(name=["finger"], position=[0.0], velocity=[0.0], effort=[0.0])
    begin = time.monotonic()
    for tick in range(COUNT):
        state.header.stamp.nanosec = (tick % 1000) * 1_000_000
        state.header.stamp.sec = tick // 1000
        state.position[0], state.effort[0] = 1e-6 * tick, float(tick)
        states.publish(state)
        setpoints.publish(Float64(data=float(tick)))
        commands.publish(Float64(data=float(-tick)))
        time.sleep(max(0.0, begin + 1e-3 * (tick + 1) - time.monotonic()))
    for publisher in (states, setpoints, commands):
        delivered(publisher)


def delivered(publisher: Publisher) -> None:
    """Wait until the recorder has got everything."""
    assert publisher.wait_for_all_acked(Duration(seconds=PATIENCE))


def samples_in(bag: Path) -> int:
    """How many samples are in a bag so far."""
    try:
        return len(read_recording(bag))
    except MicrogripperError:
        return 0


@pytest.mark.parametrize(
    ("storage", "number"), [("mcap", signal.SIGINT), ("sqlite3", signal.SIGTERM)]
)
def test_nothing_is_lost_at_1_khz(
    start: Start, watcher: Watcher, tmp_path: Path, storage: str, number: int
) -> None:
    recorder = start("recorder", out="bag", storage=storage)
    publish_at_1_khz(watcher)
    assert recorder.stop(number) == 0
    assert "0 lost, 0 samples missing" in recorder.log

    run = read_recording(tmp_path / "bag")
    assert run.warnings == ()
    np.testing.assert_array_equal(run.voltage, NUMBERS)
    np.testing.assert_array_equal(run.measured, 1e-6 * NUMBERS)
    # Each setpoint is that of its sample: the order of publishing is kept.
    np.testing.assert_array_equal(run.setpoint, NUMBERS)
    with Bag(tmp_path / "bag") as bag:
        (topic,) = (topic for topic in bag.topics if topic.name == "/microgripper/voltage_command")
        values = [deserialize_message(m, Float64).data for _, _, m in bag.messages([topic])]
    np.testing.assert_array_equal(values, -NUMBERS)


def test_what_was_flushed_survives_the_death_of_the_recorder(
    start: Start, watcher: Watcher, tmp_path: Path
) -> None:
    recorder = start("recorder", out="bag")
    publish_at_1_khz(watcher)
    watcher.until(lambda: samples_in(tmp_path / "bag") == COUNT, "the last flush")
    recorder.process.kill()
    recorder.process.wait()
    run = read_recording(tmp_path / "bag")
    assert len(run) == COUNT
    assert run.warnings


def test_other_topics_and_other_qualities(start: Start, watcher: Watcher, tmp_path: Path) -> None:
    best_effort = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    states = watcher.node.create_publisher(JointState, "joint_states", best_effort)
    texts = watcher.node.create_publisher(String, "/elsewhere/notes", QoSProfile(depth=100))
    recorder = start("recorder", out="bag", topics=["joint_states", "/elsewhere/notes"])
    for publisher in (states, texts):
        watcher.until(lambda p=publisher: p.get_subscription_count() > 0, "the recorder")
    for tick in range(20):
        state = JointState(name=["finger"], position=[0.0], effort=[float(tick)])
        state.header.stamp.nanosec = tick * 1_000_000
        states.publish(state)
    texts.publish(String(data="begun"))
    delivered(texts)
    assert recorder.stop() == 0
    np.testing.assert_array_equal(read_recording(tmp_path / "bag").voltage, np.arange(20.0))
    with Bag(tmp_path / "bag") as bag:
        assert {str(topic) for topic in bag.topics} == {
            "/elsewhere/notes (std_msgs/msg/String)",
            "/microgripper/joint_states (sensor_msgs/msg/JointState)",
        }


def test_what_was_sent_before_it_came_is_recorded_and_played_so(
    start: Start, watcher: Watcher, tmp_path: Path
) -> None:
    latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    texts = watcher.node.create_publisher(String, "/description", latched)
    texts.publish(String(data="before"))
    recorder = start("recorder", out="bag", topics=["/description"])
    watcher.until(lambda: texts.get_subscription_count() > 0, "the recorder")
    delivered(texts)
    # Who publishes later and keeps nothing is heard as well.
    later = watcher.node.create_publisher(String, "/description", QoSProfile(depth=10))
    watcher.until(lambda: later.get_subscription_count() > 0, "the recorder")
    later.publish(String(data="after"))
    delivered(later)
    assert recorder.stop() == 0
    with Bag(tmp_path / "bag") as bag:
        (topic,) = bag.topics
        found = [deserialize_message(m, String).data for _, _, m in bag.messages([topic])]
        assert offered(topic.qos) == Offered(reliable=True, latched=True)
    assert found[0] == "before"
    assert found[-1] == "after"
    watcher.node.destroy_publisher(texts)
    watcher.node.destroy_publisher(later)
    heard = []
    watcher.node.create_subscription(String, "/description", heard.append, latched)
    player = start("player", recording="bag", partners=["watcher"])
    assert player.ended() == 0
    watcher.until(lambda: len(heard) == len(found), "what was played")


@pytest.mark.parametrize("kind", ["my_rig/msg/Sample", "os/path", ".x/msg/Y", "a\nb/msg/C"])
def test_a_strange_type_does_not_end_the_recording(
    ros: Callable[..., None], ros_domain: dict[str, str], tmp_path: Path, kind: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """A stranger publishes on one of the topics; the others go on."""
    ros("--ros-args", "-p", f"out:={tmp_path / 'bag'}")
    recorder = Recorder()
    recorder.begin()
    strange = SimpleNamespace(topic_type=kind, qos_profile=QoSProfile(depth=1))
    with monkeypatch.context() as patch:
        patch.setattr(recorder, "get_publishers_info_by_topic", lambda topic: [strange])
        recorder.work(time.monotonic())
    health = recorder.health(1.0)
    assert health.message.startswith("not recorded: /microgripper/joint_states")
    assert all(str(value).isprintable() for value in health.values.values())
    recorder.leave()
    recorder.destroy_node()
