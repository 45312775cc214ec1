"""Quality of service of the topics, and what the middleware says of it.

| topic | who publishes | who subscribes |
|---|---|---|
| `joint_states` | reliable, the last 5000, deadline 0.1 s | controller: best effort, the newest |
| `voltage_command` | reliable, the last 5000, deadline 0.1 s | rig: best effort, the newest |
| `setpoint`, `voltage_setpoint` | reliable, the last 5000 | controller: reliable, the newest |
| all | lease 1 s | recorder, diagnoser: reliable, the last 5000 |

A control loop wants the newest sample: a reliable one would wait for the one before it to be sent
again. A setpoint may be sent once, by hand, so it has to arrive. Who records wants all, and was
perhaps held up by the scheduler for seconds. In lockstep a message that is lost ends the run, so
there everything is reliable.

Publishers offer a deadline, of five samples where that is more, and a lease of their liveliness, so
that anybody may ask for them. The subscriptions ask for none: they would get nothing from a
publisher that offers none, and `ros2 topic pub` is one. Where they are asked for, by the standard
`qos_overrides` parameters, what the middleware then reports is counted, and is in the node's
health.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from weakref import WeakKeyDictionary

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from microgripper_control.recordings.offered_qos import Offered

KEPT = 5000  # messages
LEASE = 1.0  # s
OVERRIDABLE = (
    QoSPolicyKind.HISTORY,
    QoSPolicyKind.DEPTH,
    QoSPolicyKind.RELIABILITY,
    QoSPolicyKind.DURABILITY,
    QoSPolicyKind.DEADLINE,
    QoSPolicyKind.LIVELINESS,
    QoSPolicyKind.LIVELINESS_LEASE_DURATION,
)
OFFERED = (QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY)

_counters: WeakKeyDictionary[Node, Counter[str]] = WeakKeyDictionary()


def quality(depth: int, *, reliable: bool = True, latched: bool = False) -> QoSProfile:
    """A new profile: rclpy writes the user's overrides into the one it is given."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def offered_by(profiles: Sequence[QoSProfile]) -> Offered:
    """What all publishers with these profiles offer."""
    return Offered(
        reliable=all(one.reliability is ReliabilityPolicy.RELIABLE for one in profiles),
        latched=all(one.durability is DurabilityPolicy.TRANSIENT_LOCAL for one in profiles),
    )


def offer(deadline: float | None = None) -> QoSProfile:
    """What a publisher offers; `deadline`, s, is the longest time between two messages."""
    profile = quality(KEPT)
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = Duration(seconds=LEASE)
    if deadline is not None:
        profile.deadline = Duration(seconds=deadline)
    return profile


def overridable(*, as_offered: bool = False) -> QoSOverridingOptions:
    """What the standard `qos_overrides` may override: all, or all that is not `as_offered`."""
    kinds = [kind for kind in OVERRIDABLE if not (as_offered and kind in OFFERED)]
    return QoSOverridingOptions(kinds)


def events_of(node: Node) -> Counter[str]:
    """How often the middleware reported what to a node, in words."""
    return _counters.setdefault(node, Counter())


def publisher_events(node: Node, topic: str) -> PublisherEventCallbacks:
    """Counts what the middleware reports of a publisher."""
    return PublisherEventCallbacks(deadline=_count(node, f"deadlines of {topic} missed"))


def subscription_events(node: Node, topic: str) -> SubscriptionEventCallbacks:
    """Counts what the middleware reports of a subscription."""
    lost_life = _count(node, f"publishers of {topic} no longer alive")

    def on_liveliness(event: object) -> None:
        if getattr(event, "not_alive_count_change", 0) > 0:
            lost_life(event)

    return SubscriptionEventCallbacks(
        deadline=_count(node, f"deadlines of {topic} missed by its publisher"),
        liveliness=on_liveliness,
        message_lost=_count(node, f"messages of {topic} lost on the way"),
    )


def _count(node: Node, what: str) -> Callable[[object], None]:
    counter = events_of(node)

    def count(event: object) -> None:
        counter[what] += int(getattr(event, "total_count_change", 1))

    return count
