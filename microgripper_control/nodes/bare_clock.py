"""A bare rclpy node that publishes a sample at each tick and notes when it is answered.

The same messages as plant and controller exchange, paced as the plant is, and nothing else: with
`bare_echo` it is what the middleware alone costs, for the benchmark to compare with. It runs for
`duration`, s, at `sample_rate`, Hz, in the executor `executor`, then writes `out`.
"""

from __future__ import annotations

import time

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.core.realtime import go_first
from microgripper_control.nodes import topics
from microgripper_control.nodes.pacing import Pace
from microgripper_control.nodes.round_trips import RoundTrips
from microgripper_control.nodes.shell import EVENTS, EXECUTORS

DISCOVERY = 30.0  # s: so long it waits for the answering node, at most,
LOOK = 0.05  # s, looking so often


class BareClock(Node):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("bare_clock", namespace=topics.NAMESPACE)
        self._trips = RoundTrips(self.declare_parameter("out", "round_trips.json").value)
        self._period = 1.0 / self.declare_parameter("sample_rate", 1000.0).value
        self._duration = self.declare_parameter("duration", 10.0).value
        self._priority = int(self.declare_parameter("realtime_priority", 0).value)
        self._executor = self.declare_parameter("executor", EVENTS).value
        self._sample = JointState(name=[topics.JOINT], position=[0.0], velocity=[0.0], effort=[0.0])
        self._samples = self.create_publisher(JointState, topics.JOINT_STATES, 10)
        self._answers = self.create_subscription(
            Float64, topics.VOLTAGE_COMMAND, self._on_answer, 10
        )

    def run(self) -> None:
        """Publish at every tick until the duration is over."""
        executor = EXECUTORS[self._executor]()
        executor.add_node(self)
        if self._priority:
            go_first(self._priority)
        patience = time.monotonic() + DISCOVERY
        while not self._meets_partner() and time.monotonic() < patience:
            executor.spin_once(timeout_sec=LOOK)
        now = time.monotonic()
        pace, end = Pace(self._period, now), now + self._duration
        while now < end:
            executor.spin_once(timeout_sec=pace.wait(now))
            now = time.monotonic()
            if pace.due(now):
                self._trips.sent()
                self._samples.publish(self._sample)
                now = time.monotonic()
        executor.remove_node(self)
        executor.shutdown()
        self._trips.write()

    def _meets_partner(self) -> bool:
        return bool(self._samples.get_subscription_count() and self._answers.get_publisher_count())

    def _on_answer(self, message: Float64) -> None:
        self._trips.answered()


def main() -> None:
    """Run the node."""
    rclpy.init()
    BareClock().run()


if __name__ == "__main__":
    main()
