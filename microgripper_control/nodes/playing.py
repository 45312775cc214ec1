"""The two ways in which `player` plays a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.nodes import qos, topics
from microgripper_control.nodes.pacing import SampleNumber
from microgripper_control.nodes.shell import POLL
from microgripper_control.nodes.stamp_rate import ENOUGH, StampRate
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.offered_qos import offered
from microgripper_control.recordings.read import read_recording

MOST_AT_ONCE = 100  # messages, before a signal is looked for again


class Playing(Protocol):
    """What the node drives; `played` counts the messages that are out."""

    played: int
    is_over: bool

    @property
    def publishers(self) -> Sequence[Publisher]:
        """All that it publishes with."""
        ...

    def work(self, now: float) -> float:
        """Publish what is due at `now` (s, monotonic clock); time until the next call, s."""
        ...


class AsRecorded:
    """Publishes the messages of a bag as they were published, `speed` times as fast.

    Raises MicrogripperError where there is no bag or a wanted topic is not in it.
    """

    def __init__(self, node: Node, path: Path, wanted: Sequence[str], speed: float) -> None:
        self._bag = Bag(path)
        present = {topic.name: topic for topic in self._bag.topics}
        if not present:
            raise MicrogripperError(f"{path}: has no messages; record it again")
        absent = [name for name in wanted if name not in present]
        if absent:
            listed = ", ".join(map(str, self._bag.topics))
            raise MicrogripperError(f"{path}: no topic {', '.join(absent)}; it has {listed}")
        chosen = [present[name] for name in wanted] or list(present.values())
        self._by_name = {
            topic.name: node.create_publisher(
                topics.type_named(topic.type),
                topic.name,
                qos.quality(qos.KEPT, latched=offered(topic.qos).latched),
            )
            for topic in chosen
        }
        self.publishers = list(self._by_name.values())
        self.played = 0
        self.is_over = False
        self._messages = self._bag.messages(chosen)
        self._speed = speed
        self._next = next(self._messages, None)
        self._first = self._next[1] if self._next else 0  # ns
        self._start: float | None = None

    def work(self, now: float) -> float:
        """As `Playing` says."""
        if self._start is None:
            self._start = now
        for _ in range(MOST_AT_ONCE):
            if self._next is None:
                self.is_over = True
                self._bag.close()
                return POLL
            topic, stamp, message = self._next
            wait = self._start + (stamp - self._first) * 1e-9 / self._speed - now
            if wait > 0.0:
                return wait
            self._by_name[topic.name].publish(message)
            self.played += 1
            self._next = next(self._messages, None)
        return 0.0


class AsAnswers:
    """Answers each sample of the plant with the voltage that followed it in the recording.

    The answer to sample k is the recorded u[k+1]; the recorded u[0] has to be what the plant begins
    with, its `initial_voltage`.
    """

    def __init__(self, node: Node, path: Path) -> None:
        recording = read_recording(path, needs_displacement=False)
        self._voltages: list[float] = recording.voltage.tolist()
        self._rate = 1.0 / recording.sample_period  # Hz
        self._number = SampleNumber(self._rate)
        self._stamps = StampRate(self._rate)
        self._answer = Float64()
        self._answers = topics.publish_on(node, topics.VOLTAGE_COMMAND)
        self._samples = topics.Newest(node, topics.JOINT_STATES, self._on_sample)
        self.publishers = [self._answers]
        self.played = 0
        self.is_over = False

    def work(self, now: float) -> float:
        """As `Playing` says: the samples set the pace."""
        self._samples.open(if_published=True)
        return POLL

    def _on_sample(self, message: JointState) -> None:
        stamp = topics.stamp_of(message)
        self._stamps.note(stamp)
        # Voltages would be left out or held, and nobody would see it.
        if self.played < ENOUGH and self._stamps.is_another:
            raise MicrogripperError(
                f"the plant samples at {self._stamps.told:.6g} Hz, the recording at "
                f"{self._rate:.6g} Hz; set the plant's sample_rate to that"
            )
        following = self._number.of(stamp) + 1
        last = len(self._voltages) - 1
        self._answer.data = self._voltages[min(following, last)]
        self._answers.publish(self._answer)
        self.played += 1
        self.is_over = following > last
