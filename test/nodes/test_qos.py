"""Quality of service over DDS: what is overridden takes effect, and its events are reported."""

from __future__ import annotations

import time
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from running_nodes import Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.nodes import qos

pytestmark = pytest.mark.ros


class Reports:
    """The last report of each node."""

    def __init__(self, watcher: Watcher) -> None:
        self.found = watcher.messages(DiagnosticArray, "/diagnostics")

    def last(self) -> Any:  # noqa: ANN401
        return self.found[-1].status[0] if self.found else None

    def value(self, key: str) -> str:
        status = self.last()
        return {one.key: one.value for one in status.values}.get(key, "") if status else ""


def sample() -> JointState:
    state = JointState(name=["finger"], position=[0.0], effort=[0.0])
    state.header.stamp.sec, state.header.stamp.nanosec = divmod(time.monotonic_ns(), 10**9)
    return state


@pytest.mark.parametrize(
    ("name", "topic"),
    [("controller", "joint_states"), ("recorder", "/microgripper/joint_states")],
)
def test_a_deadline_that_is_asked_for_is_watched_by_the_middleware(
    start: Start, watcher: Watcher, name: str, topic: str
) -> None:
    reports = Reports(watcher)
    start(name, **{"qos_overrides./microgripper/joint_states.subscription.deadline": 50_000_000})
    publisher = watcher.node.create_publisher(JointState, "joint_states", qos.offer(0.05))
    watcher.until(lambda: publisher.get_subscription_count() > 0, f"the {name}")
    key = f"deadlines of {topic} missed by its publisher, says the middleware"

    def missed() -> bool:
        publisher.publish(sample())
        end = time.monotonic() + 0.2
        watcher.until(lambda: time.monotonic() > end, "a deadline to pass")
        return int(reports.value(key) or 0) > 0

    watcher.until(missed, "a missed deadline in the report")


def test_setpoints_of_two_publishers_are_reported(start: Start, watcher: Watcher) -> None:
    reports = Reports(watcher)
    start("controller")
    states = watcher.publisher(JointState, "joint_states")
    first = watcher.publisher(Float64, "setpoint")
    second = watcher.node.create_publisher(Float64, "setpoint", 10)
    watcher.until(lambda: second.get_subscription_count() > 0, "the controller")

    def reported() -> bool:
        for publisher in (first, second):
            publisher.publish(Float64(data=5e-6))
            end = time.monotonic() + 0.005  # of two at once the controller would take the newer
            watcher.until(lambda end=end: time.monotonic() > end, "half a sample period to pass")
        states.publish(sample())
        return "2 publishers: watcher, watcher" in reports.value("publishers of setpoint")

    watcher.until(reported, "the report of two publishers")
    assert reports.last().level != b"\0"
