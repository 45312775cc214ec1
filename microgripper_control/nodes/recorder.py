"""Records topics into a rosbag2, serialized as they come.

A topic is subscribed to as soon as somebody publishes on it, reliably and with what was sent before
unless a publisher offers less; what they offered is in the bag, too. The messages are taken in
batches, past the executor, which would spend a callback on each. They are stored under the time at
which they were published: that they were received in the same order is not certain, and of a sample
and the setpoint that answers it the order matters.

The bag is flushed every half second, so that no more than that dies with the process, and completed
when the node is asked to end. Two kinds of loss are told apart: messages that were published and
did not arrive here, by their sequence numbers, and samples that are missing by the stamps of
`joint_states`, be it that the plant missed those ticks.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from datetime import datetime
from operator import itemgetter

from rclpy.subscription import Subscription

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.nodes import qos, topics
from microgripper_control.nodes.health import Health, Level
from microgripper_control.nodes.parameters import declare_path, declare_text, declare_texts
from microgripper_control.nodes.shell import Shell, run
from microgripper_control.recordings.bag_writer import STORAGES, BagWriter
from microgripper_control.recordings.losses import JointStates, Sequence
from microgripper_control.recordings.offered_qos import Offered

USUAL_TOPICS = (
    topics.JOINT_STATES,
    topics.SETPOINT,
    topics.VOLTAGE_SETPOINT,
    topics.VOLTAGE_COMMAND,
)
TAKE_PERIOD = 0.01  # s
LOOK_PERIOD = 0.05  # s, between looks for publishers
FLUSH_PERIOD = 0.5  # s
QUIET = 0.1  # s without a message: at the end nothing is on its way any more
LONGEST_END = 1.0  # s


class Recorder(Shell):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("recorder")
        name = datetime.now().strftime("recording_%Y_%m_%d-%H_%M_%S")
        folder = declare_path(self, "out", name, "folder of the bag, a new one")
        storage = declare_text(
            self, "storage", "mcap", "format of the bag", choices=list(STORAGES), read_only=True
        )
        wanted = declare_texts(self, "topics", USUAL_TOPICS, "topics to record")
        self._wanted = [self.resolve_topic_name(topic) for topic in wanted]
        self._stamped = self.resolve_topic_name(topics.JOINT_STATES)
        self._taken: dict[str, Subscription] = {}
        self._kinds: dict[str, str] = {}  # of the topics that are taken
        self._sequences: dict[str, Sequence] = {}
        self._refused: dict[str, str] = {}  # topics that cannot be recorded, and why
        self._samples = JointStates()
        self._looked = self._flushed = 0.0
        self._place, self._storage = folder, storage
        self._bag: BagWriter

    def begin(self) -> None:
        """Open the bag."""
        self._bag = BagWriter(self._place, self._storage)

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Those that the executor serves: none of the recorded ones."""
        recorded = self._taken.values()
        return (one for one in super().subscriptions if one not in recorded)

    def work(self, now: float) -> float:
        """As `Shell` says."""
        self._take()
        if now - self._looked >= LOOK_PERIOD:
            self._looked = now
            for topic in self._wanted:
                self._look(topic)
        if now - self._flushed >= FLUSH_PERIOD:
            self._flushed = now
            self._bag.flush()
        return TAKE_PERIOD

    def leave(self) -> None:
        """Take what is on its way, then complete the bag."""
        try:
            now = time.monotonic()
            end, quiet = now + LONGEST_END, now + QUIET
            while time.monotonic() < min(end, quiet) and not self._bag.broken:
                if self._take():
                    quiet = time.monotonic() + QUIET
                time.sleep(TAKE_PERIOD)
        finally:
            self._bag.close()
        self.get_logger().info(f"{self._bag.path}: {self._summary()}")

    def _take(self) -> int:
        """Write what has come; how many messages that was."""
        batch = []
        for topic, subscription in self._taken.items():
            for message, info in topics.taken(subscription, raw=True):
                batch.append((info["source_timestamp"], topic, message, info))
        batch.sort(key=itemgetter(0))
        for stamp, topic, message, info in batch:
            if self._is_announced(topic):
                self._note(topic, message, info["publication_sequence_number"])
                self._bag.write(topic, stamp, message)
        return len(batch)

    def _is_announced(self, topic: str) -> bool:
        """Whether the bag has the topic, from its first message on: empty ones are in the way."""
        if topic in self._sequences:
            return True
        if topic not in self._refused:
            try:
                profile = qos.offered_by([self._taken[topic].qos_profile]).as_yaml(qos.KEPT)
                self._bag.add_topic(topic, self._kinds[topic], profile)
            except MicrogripperError as error:
                if self._bag.broken:
                    raise
                self._refuse(topic, error)
                return False
            self._sequences[topic] = Sequence()
        return topic in self._sequences

    def _refuse(self, topic: str, error: MicrogripperError) -> None:
        """Go on without a topic: the others are still to be recorded."""
        self._refused[topic] = str(error)
        self.get_logger().warning(f"{topic} is not recorded: {error}")

    def _note(self, topic: str, message: bytes, number: int) -> None:
        self._sequences[topic].note(number)
        if topic == self._stamped:
            self._samples.note(message)

    def _look(self, topic: str) -> None:
        """Subscribe where that was not done, or not so that messages would come."""
        if topic in self._refused:
            return
        publishers = self.get_publishers_info_by_topic(topic)
        if not publishers:
            return
        self._kinds.setdefault(topic, publishers[0].topic_type)
        profiles = [publisher.qos_profile for publisher in publishers]
        present = self._taken.get(topic)
        if present is None:
            try:
                self._subscribe(topic, qos.offered_by(profiles))
            except MicrogripperError as error:
                self._refuse(topic, error)
            return
        wanted = qos.offered_by([present.qos_profile])
        if (less := qos.offered_by([present.qos_profile, *profiles])) != wanted:
            self.destroy_subscription(present)
            self._subscribe(topic, less)

    def _subscribe(self, topic: str, offered: Offered) -> None:
        kind = topics.type_named(self._kinds[topic])
        quality = qos.quality(qos.KEPT, reliable=offered.reliable, latched=offered.latched)
        self._taken[topic] = self.create_subscription(
            kind,
            topic,
            topics.never_called,
            quality,
            event_callbacks=qos.subscription_events(self, topic),
            qos_overriding_options=qos.overridable(as_offered=True),
            raw=True,
        )

    def _summary(self) -> str:
        counts = [f"{one.count} of {topic}" for topic, one in self._sequences.items()]
        lost = sum(one.lost for one in self._sequences.values())
        missing = self._samples.missing
        return f"{', '.join(counts) or 'no messages'}; {lost} lost, {missing} samples missing"

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        counts = {f"messages of {topic}": one.count for topic, one in self._sequences.items()}
        lost = sum(one.lost for one in self._sequences.values())
        values: dict[str, object] = {
            "messages lost": lost,
            "samples missing": self._samples.missing,
            **counts,
        }
        if self._refused:
            refused = ", ".join(self._refused)
            return Health(f"not recorded: {refused}", Level.WARN, {**values, **self._refused})
        if lost:
            return Health("messages lost", Level.WARN, values)
        if self._stamped in self._wanted and self._stamped not in self._sequences:
            return Health("waiting for joint_states", Level.OK, values)
        return Health(values=values)


def main() -> None:
    """Run the node."""
    run(Recorder)


if __name__ == "__main__":
    main()
