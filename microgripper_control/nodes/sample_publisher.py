"""Publishes the samples of a rig; the messages are made once and sent over and over."""

from __future__ import annotations

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.nodes import qos, topics
from microgripper_control.plant.rig import Rig


class SamplePublisher:
    """On `joint_states` and `displacement`, each `period`, s, after where asked `/clock`."""

    def __init__(self, node: Node, period: float) -> None:
        self._node = node
        self.states = topics.publish_on(node, topics.JOINT_STATES, period)
        self._displacements = topics.publish_on(node, topics.DISPLACEMENT)
        self._clock = node.create_publisher(Clock, "/clock", qos.quality(1))
        self._state = JointState(name=[topics.JOINT], position=[0.0], velocity=[0.0], effort=[0.0])
        self._displacement = Float64()
        self._time = Clock()

    def publish(self, rig: Rig, stamp: int, *, tell_time: bool) -> None:
        """Publish the rig's newest sample, taken at `stamp`, ns."""
        state = self._state
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(stamp, 10**9)
        if tell_time:
            self._time.clock = state.header.stamp
            self._clock.publish(self._time)
        state.position[0] = rig.position
        state.velocity[0] = rig.velocity
        state.effort[0] = rig.voltage
        self.states.publish(state)
        self._displacement.data = rig.position
        self._displacements.publish(self._displacement)

    def close(self) -> None:
        """Withdraw the topics."""
        for publisher in (self.states, self._displacements, self._clock):
            self._node.destroy_publisher(publisher)
