"""A node's health, once a second on `/diagnostics`; changes for the worse are logged once."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

PERIOD = 1.0  # s


class Level(enum.IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3  # nothing comes that a state could be read off


@dataclass(frozen=True)
class Health:
    """How a node is: what is wrong, if anything, and the numbers behind it, with their units.

    A message with numbers in it has a `cause` without: as long as that stays, it is no news.
    """

    message: str = "ok"
    level: Level = Level.OK
    values: Mapping[str, object] = field(default_factory=dict)
    cause: str = ""

    @property
    def news(self) -> tuple[Level, str]:
        """What is logged when it changes."""
        return self.level, self.cause or self.message


class Reporter:
    """Publishes a node's health."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._last = Health()

    def report(self, health: Health) -> None:
        """Publish; log what was not there in the report before."""
        values = [KeyValue(key=key, value=_text(value)) for key, value in health.values.items()]
        status = DiagnosticStatus(
            level=bytes([health.level]),
            name=self._node.get_fully_qualified_name().lstrip("/"),
            message=health.message,
            hardware_id="microgripper",
            values=values,
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
        if health.news != self._last.news:
            # In two lines: rclpy takes each for a log statement of one severity.
            if health.level is Level.OK:
                self._node.get_logger().info(health.message)
            else:
                self._node.get_logger().warning(health.message)
        self._last = health


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
