"""The topics: names, types, publishers and subscriptions.

All are relative to the node's namespace. Their quality of service is that of `qos`.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib import import_module
from typing import Any, cast

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.nodes import qos

NAMESPACE = "microgripper"
JOINT = "finger"

JOINT_STATES = (
    "joint_states"  # one sample: stamp t[k], position x[k] m, velocity m/s, effort u[k] V
)
DISPLACEMENT = "displacement"  # x[k], m
VOLTAGE_COMMAND = "voltage_command"  # V
SETPOINT = "setpoint"  # wanted displacement, m
VOLTAGE_SETPOINT = "voltage_setpoint"  # wanted voltage, V, for the controller's mode open_loop
GAP = "gap"  # between the rig and its model, rms, m
NOISE_FLOOR = "noise_floor"  # what of the gap nothing could predict, rms, m

TYPES: dict[str, type] = {
    JOINT_STATES: JointState,
    DISPLACEMENT: Float64,
    VOLTAGE_COMMAND: Float64,
    SETPOINT: Float64,
    VOLTAGE_SETPOINT: Float64,
    GAP: Float64,
    NOISE_FLOOR: Float64,
}
TYPE_NAME = re.compile(r"([a-z][a-z0-9_]*)/msg/([A-Z][A-Za-z0-9]*)")
DEADLINES = {JOINT_STATES: 0.1, VOLTAGE_COMMAND: 0.1}  # s, offered; the samples' guards are faster
LATE = 5.0  # sample periods, at least: at less than 50 Hz it takes longer
DELIVERY_TIMEOUT = 4.0  # s


def publish_on(node: Node, topic: str, period: float = 0.0) -> Publisher:
    """A publisher on one of the topics above, of a message each `period`, s, where it has one."""
    deadline = DEADLINES.get(topic)
    return node.create_publisher(
        TYPES[topic],
        topic,
        qos.offer(deadline and max(deadline, LATE * period)),
        event_callbacks=qos.publisher_events(node, topic),
        qos_overriding_options=qos.overridable(),
    )


def await_delivery(publishers: Iterable[Publisher]) -> None:
    """Wait until everybody has what was published: with its publisher a message may be lost.

    That takes up to a heartbeat of the middleware, 3 s; a reader that has died is given up then.
    """
    end = time.monotonic() + DELIVERY_TIMEOUT
    for publisher in publishers:
        left = max(0.0, end - time.monotonic())
        publisher.wait_for_all_acked(Duration(seconds=left))


class Newest:
    """A subscription to the newest message of one of the topics above, once it is opened."""

    def __init__(self, node: Node, topic: str, callback: Callable[[Any], None]) -> None:
        self._node = node
        self._topic = topic
        self._callback = callback
        self._subscription: Subscription | None = None

    @property
    def is_open(self) -> bool:
        """Whether it is subscribed."""
        return self._subscription is not None

    def open(self, *, if_published: bool = False, reliable: bool = True) -> None:
        """Subscribe if that was not done; with `if_published` only where there is a publisher.

        A publisher that counts a subscription made in this order can rely on it: the subscriber
        knows of the publisher, too. Made in the other order, the first messages may be lost.
        """
        if self.is_open or (if_published and not self._node.count_publishers(self._topic)):
            return
        self._subscription = self._node.create_subscription(
            TYPES[self._topic],
            self._topic,
            self._callback,
            qos.quality(1, reliable=reliable),
            event_callbacks=qos.subscription_events(self._node, self._topic),
            qos_overriding_options=qos.overridable(),
        )

    def close(self) -> None:
        """Unsubscribe."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None


class Batches:
    """A subscription to all messages of one of the topics above, which are taken in batches.

    That is past the executor, which would spend a callback on each, four times what taking it
    costs. So a node has to leave `subscription` out of the `subscriptions` that it shows.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self.subscription = node.create_subscription(
            TYPES[topic],
            topic,
            never_called,
            qos.quality(qos.KEPT),
            event_callbacks=qos.subscription_events(node, topic),
            qos_overriding_options=qos.overridable(),
        )

    def take(self) -> Iterator[Any]:
        """The messages that have come since the last call, oldest first."""
        return (message for message, _ in taken(self.subscription))


def taken(subscription: Subscription, *, raw: bool = False) -> Iterator[tuple[Any, dict[str, int]]]:
    """The messages that have come, oldest first, each with what the middleware knows of it.

    No more than are kept, so that it ends even if they come faster than they are taken.
    """
    handle = subscription.handle
    with handle:
        for _ in range(qos.KEPT):
            one = handle.take_message(subscription.msg_type, raw)
            if one is None:
                return
            yield one


def never_called(message: object) -> None:
    """The callback of a subscription whose messages are taken past the executor."""


def type_named(name: str) -> type:
    """The message type of a name like `std_msgs/msg/Float64`, of any package that is installed."""
    parts = TYPE_NAME.fullmatch(name)
    if parts is None:  # it may come from a bag, and names what is imported
        raise MicrogripperError(f"{name!r:.80} is not the name of a message type")
    try:
        return cast(type, getattr(import_module(f"{parts[1]}.msg"), parts[2]))
    except (ImportError, AttributeError):
        raise MicrogripperError(f"message type {name} is not installed here") from None


def finger(message: JointState) -> tuple[float, float]:
    """Displacement, m, and voltage, V, in a message of joint_states; NaN where it has none.

    Only the joint `finger` counts, or the first where the message names none at all.
    """
    names = message.name
    if names and JOINT not in names:
        return math.nan, math.nan
    at = names.index(JOINT) if names else 0
    position, effort = message.position, message.effort
    return (
        position[at] if at < len(position) else math.nan,
        effort[at] if at < len(effort) else math.nan,
    )


def stamp_of(message: JointState) -> int:
    """The stamp, ns."""
    stamp = message.header.stamp
    nanoseconds: int = stamp.sec * 10**9 + stamp.nanosec
    return nanoseconds


def missing_partners(node: Node, publisher: Publisher, partners: Sequence[str]) -> list[str]:
    """Those of the named nodes that do not yet get what the publisher publishes."""
    subscriptions = node.get_subscriptions_info_by_topic(publisher.topic_name)
    present = {subscription.node_name for subscription in subscriptions}
    missing = [name for name in partners if name not in present]
    if not missing and publisher.get_subscription_count() < len(subscriptions):
        return sorted(present)  # known of, but not all are connected yet
    return missing
