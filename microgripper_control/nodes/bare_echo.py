"""A bare rclpy node that answers each sample at once: `bare_clock` says what for."""

from __future__ import annotations

from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.core.realtime import go_first
from microgripper_control.nodes import topics
from microgripper_control.nodes.shell import EVENTS, EXECUTORS, POLL


class BareEcho(Node):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("bare_echo", namespace=topics.NAMESPACE)
        self.priority = int(self.declare_parameter("realtime_priority", 0).value)
        self.executor_name = self.declare_parameter("executor", EVENTS).value
        self._answer = Float64()
        self._answers = self.create_publisher(Float64, topics.VOLTAGE_COMMAND, 10)
        self.create_subscription(JointState, topics.JOINT_STATES, self._on_sample, 10)

    def _on_sample(self, message: JointState) -> None:
        self._answer.data = message.effort[0]
        self._answers.publish(self._answer)


def main() -> None:
    """Run the node."""
    rclpy.init()
    node = BareEcho()
    executor = EXECUTORS[node.executor_name]()
    executor.add_node(node)
    if node.priority:
        go_first(node.priority)
    node.get_logger().info("ready")
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while node.context.ok():
            executor.spin_once(timeout_sec=POLL)


if __name__ == "__main__":
    main()
