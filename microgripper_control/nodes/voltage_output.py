"""The way out for voltages: the guard's, and no other.

`VoltageGuard` keeps range and rate, and what it holds is all that can be published here. On the way
down (`Descent`) there are no samples to answer: a clock sets the pace.
"""

from __future__ import annotations

import math
import time

from rclpy.node import Node
from std_msgs.msg import Float64

from microgripper_control.control.limits import VoltageGuard
from microgripper_control.nodes import topics

REPEATED = 3  # times the safe voltage is sent in the end: nobody could send it again later


class VoltageOutput:
    """Publishes `voltage_command`, while it controls each `period`, s."""

    def __init__(self, node: Node, period: float) -> None:
        self._node = node
        self._message = Float64()
        self._sent = -math.inf
        self.publisher = topics.publish_on(node, topics.VOLTAGE_COMMAND, period)

    @property
    def elapsed(self) -> float:
        """Time since the last voltage went out, s; infinite if none did."""
        return time.monotonic() - self._sent

    def send(self, guard: VoltageGuard) -> float:
        """Publish the guard's voltage; when that was (s, monotonic clock)."""
        self._message.data = guard.voltage
        self.publisher.publish(self._message)
        self._sent = time.monotonic()  # not before: between the two the process may be held up
        return self._sent

    def close(self) -> None:
        """Withdraw the topic."""
        self._node.destroy_publisher(self.publisher)


class Descent:
    """The way to the safe voltage at the ramp rate, a voltage each sample period."""

    def __init__(self, output: VoltageOutput, guard: VoltageGuard, period: float) -> None:
        self._output = output
        self._guard = guard
        self._period = period
        self._due = -math.inf
        self._repeated = 0

    @property
    def is_over(self) -> bool:
        """Whether the safe voltage was sent, several times."""
        return self._repeated == REPEATED

    def work(self, now: float) -> float:
        """Send what is due at `now` (s, monotonic clock); time until the next is, s."""
        if now >= self._due and not self.is_over:
            guard = self._guard
            self._repeated += guard.voltage == guard.limits.safe
            guard.passed(self._period)  # whoever calls, the clock here sets the pace
            guard.ramp_to(guard.limits.safe)
            self._output.send(guard)
            # What was slept through is not caught up on: a bunch would be faster than the rate.
            on_time = now < self._due + self._period
            self._due = (self._due if on_time else now) + self._period
        return math.inf if self.is_over else max(0.0, self._due - now)

    def finish(self) -> None:
        """Go all the way, and come back when it is over."""
        while not self.is_over:
            time.sleep(min(self.work(time.monotonic()), self._period))
