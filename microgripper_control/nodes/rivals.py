"""Notices that more than one publisher is at work on a topic that wants one.

A publisher whose process was killed stays listed for the middleware's lease, 20 s. So two that are
listed prove nothing, unless both have been for longer than that, or more messages come than one
would send.
"""

from __future__ import annotations

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo

LEASE = 25.0  # s, and some to spare
CROWDED = 1.5  # messages for each sample of the plant; more are not one publisher's


class Rivals:
    """Look about once a second."""

    def __init__(self, node: Node, topic: str) -> None:
        self._node = node
        self._topic = node.resolve_topic_name(topic)
        self._since: dict[bytes, float] = {}  # publishers by their ids, when first seen, s
        self.state = "ok"

    def names(self) -> list[str]:
        """The nodes that publish, one name a publisher."""
        return sorted(one.node_name for one in self._listed())

    def look(self, now: float, per_sample: float = 0.0) -> bool:
        """Whether there are rivals at `now`, s; `per_sample` messages came since the last look."""
        listed = self._listed()
        ids = [bytes(one.endpoint_gid) for one in listed]
        self._since = {one: self._since.get(one, now) for one in ids}
        lasting = sum(now - since > LEASE for since in self._since.values())
        rivals = lasting > 1 or (len(ids) > 1 and per_sample > CROWDED)
        names = ", ".join(sorted(one.node_name for one in listed))
        self.state = f"{len(ids)} publishers: {names}" if rivals else "ok"
        return rivals

    def _listed(self) -> list[TopicEndpointInfo]:
        return self._node.get_publishers_info_by_topic(self._topic)
