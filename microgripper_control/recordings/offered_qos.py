"""What the publishers of a topic offered to all who listen, as a bag keeps it.

A bag has whole profiles; what decides whether its messages reach somebody is whether they are sent
again when lost (reliable), and whether who comes late gets those from before (latched).
"""

from __future__ import annotations

from typing import NamedTuple

import yaml
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability
from rosbags.rosbag2 import ReaderError
from rosbags.rosbag2.metadata import parse_qos

from microgripper_control.core.errors import MicrogripperError

FOREVER = {"sec": 2147483647, "nsec": 4294967295}  # as rosbag2 writes it


class Offered(NamedTuple):
    """What all publishers of a topic offer."""

    reliable: bool = True
    latched: bool = False

    def as_yaml(self, depth: int) -> str:
        """The profile of a publisher that keeps `depth` messages, in rosbag2's YAML."""
        reliability = QosReliability.RELIABLE if self.reliable else QosReliability.BEST_EFFORT
        durability = QosDurability.TRANSIENT_LOCAL if self.latched else QosDurability.VOLATILE
        profile = {
            "history": QosHistory.KEEP_LAST.name.lower(),
            "depth": depth,
            "reliability": reliability.name.lower(),
            "durability": durability.name.lower(),
            "deadline": FOREVER,
            "lifespan": FOREVER,
            "liveliness": QosLiveliness.AUTOMATIC.name.lower(),
            "liveliness_lease_duration": FOREVER,
            "avoid_ros_namespace_conventions": False,
        }
        text: str = yaml.safe_dump([profile])
        return text


def profiles_in(text: str) -> list[Qos]:
    """The profiles in rosbag2's YAML; MicrogripperError where it holds something else."""
    try:
        return parse_qos(text)
    except (ReaderError, LookupError, TypeError, ValueError, AttributeError, RecursionError):
        raise MicrogripperError(f"bad QoS {text!r:.60}") from None


def offered(text: str) -> Offered:
    """What profiles in rosbag2's YAML offer; the usual where there are none, or none are read."""
    try:
        profiles = profiles_in(text)
    except MicrogripperError:
        profiles = []
    if not profiles:
        return Offered()
    return Offered(
        reliable=all(one.reliability is not QosReliability.BEST_EFFORT for one in profiles),
        latched=all(one.durability is QosDurability.TRANSIENT_LOCAL for one in profiles),
    )
