"""Sees every message of the control loop, under the time at which it was published.

It lives in a process of its own and answers questions over a pipe: the process that starts and
kills the nodes has no ROS. Messages are taken past the executor, as `recorder` does.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from operator import itemgetter
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from invariants import Invariants
from nursery import PERIOD, Nursery, Place
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from microgripper_control.nodes import qos, topics

TAKE_PERIOD = 0.003  # s
REMEMBERED = 20_000  # messages of a topic
NUMBERED = 100_000  # messages of a topic whose numbers are remembered: all of a network's trials
DIAGNOSTICS = "/diagnostics"
WATCHED = (topics.VOLTAGE_COMMAND, topics.JOINT_STATES, topics.SETPOINT)
CLOSE = 0.5e-6  # m; the setpoint is tracked
SETTLED = 50  # samples in a row

Course = list[tuple[float, float]]  # time of publication, s; value


class Witness:
    """The questions that can be asked; each is answered with what has come so far."""

    def __init__(
        self,
        nursery: Nursery,
        place: Place | None = None,
        *,
        period: float = PERIOD,
        reliable: bool = True,
        watched: tuple[str, ...] = WATCHED,
    ) -> None:
        self._pipe, theirs = Pipe()
        watching = _Watching(theirs, period, watched, reliable=reliable)
        self.process = nursery.fork("witness", watching.run, place=place)

    def _ask(self, question: str, *details: object) -> Any:  # noqa: ANN401 (of any question)
        try:
            self._pipe.send((question, details))
            if self._pipe.poll(20.0):
                return self._pipe.recv()
        except (EOFError, OSError):
            pass
        raise RuntimeError(f"the witness does not answer: {self.process.log.read_text()}")

    def account(self) -> Invariants:
        """Of the voltages on the topic since the last account."""
        found: Invariants = self._ask("account")
        return found

    def since(self, topic: str, start: float) -> Course:
        """What was published on a topic from `start` on, s; of joint_states the voltage."""
        course: Course = self._ask("since", topic, start)
        return course

    def numbers(self, topic: str) -> dict[float, int]:
        """The publisher's number of each message that has come, by its time of publication, s."""
        numbers: dict[float, int] = self._ask("numbers", topic)
        return numbers

    def health(self, name: str) -> dict[str, str]:
        """The values that a node last reported on `/diagnostics`."""
        values: dict[str, str] = self._ask("health", name)
        return values

    def tracking_since(self, start: float) -> float | None:
        """From when on after `start`, s, the setpoint was tracked for a while; None: not yet."""
        found: float | None = self._ask("tracking_since", start)
        return found

    def until(self, condition: Callable[[], Any], timeout: float) -> Any:  # noqa: ANN401
        """What the condition gives once that is true; None if it never is in time, s."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            found = condition()
            if found:
                return found
            time.sleep(0.01)
        return None


@dataclass(frozen=True)
class _Sample:
    at: float  # s
    error: float  # m


class _Watching:
    """The process of the witness."""

    def __init__(
        self, pipe: Connection, period: float, watched: tuple[str, ...], *, reliable: bool
    ) -> None:
        self._pipe = pipe
        self._watched = watched
        self._reliable = reliable
        self._invariants = Invariants(period)
        self._health: dict[str, dict[str, str]] = {}
        self._courses: dict[str, deque[tuple[float, float]]] = {
            topic: deque(maxlen=REMEMBERED) for topic in watched
        }
        self._numbers: dict[str, deque[tuple[float, int]]] = {
            topic: deque(maxlen=NUMBERED) for topic in watched
        }
        self._errors: deque[_Sample] = deque(maxlen=REMEMBERED)
        self._setpoint = 0.0

    def run(self) -> None:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = Node("witness", namespace=topics.NAMESPACE)

        def quality() -> QoSProfile:
            return qos.quality(qos.KEPT, reliable=self._reliable)

        batches = {
            topic: node.create_subscription(topics.TYPES[topic], topic, _never_called, quality())
            for topic in self._watched
        }
        batches[DIAGNOSTICS] = node.create_subscription(
            DiagnosticArray, DIAGNOSTICS, _never_called, 100
        )
        while True:
            self._take(batches)
            if self._pipe.poll(TAKE_PERIOD):
                question, details = self._pipe.recv()
                self._pipe.send(getattr(self, question)(*details))

    def _take(self, batches: dict[str, Any]) -> None:
        batch = []
        for topic, subscription in batches.items():
            handle = subscription.handle
            with handle:
                while (taken := handle.take_message(subscription.msg_type, False)) is not None:
                    message, info = taken
                    at = info["source_timestamp"] * 1e-9
                    batch.append((at, topic, message))
                    if topic in self._numbers:
                        self._numbers[topic].append((at, info["publication_sequence_number"]))
        for at, topic, message in sorted(batch, key=itemgetter(0)):
            self._note(at, topic, message)

    def _note(self, at: float, topic: str, message: Any) -> None:  # noqa: ANN401
        if topic == DIAGNOSTICS:
            for status in message.status:
                name = status.name.rpartition("/")[2]
                self._health[name] = {one.key: one.value for one in status.values}
            return
        if topic == topics.JOINT_STATES:
            displacement, voltage = topics.finger(message)
            self._courses[topic].append((at, voltage))
            self._errors.append(_Sample(at, abs(displacement - self._setpoint)))
            return
        self._courses[topic].append((at, message.data))
        if topic == topics.SETPOINT:
            self._setpoint = message.data
        else:
            self._invariants.note(at, message.data)

    def account(self) -> Invariants:
        closed, self._invariants = self._invariants, self._invariants.anew()
        return closed

    def health(self, name: str) -> dict[str, str]:
        return self._health.get(name, {})

    def since(self, topic: str, start: float) -> Course:
        return [entry for entry in self._courses[topic] if entry[0] >= start]

    def numbers(self, topic: str) -> dict[float, int]:
        return dict(self._numbers[topic])

    def tracking_since(self, start: float) -> float | None:
        in_row: list[float] = []
        for sample in self._errors:
            if sample.at < start:
                continue
            in_row = [*in_row, sample.at] if sample.error <= CLOSE else []
            if len(in_row) == SETTLED:
                return in_row[0]
        return None


def _never_called(message: object) -> None:
    """The messages are taken by `_Watching`."""
