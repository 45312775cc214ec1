"""Runs of two processes that answer each other over DDS, and what their times say."""

from __future__ import annotations

import importlib.util
import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.demo.processes import POLL, Node, Nodes

OURS, BARE = ("controller", "timed_plant"), ("bare_echo", "bare_clock")
SETTLING = 1.0  # s after the first answer that does not count: both have just begun
DISCOVERY = 4.0  # s until the first answer, at most: on a busy machine it was seen to take 2.6
STARTING = 60.0  # s
READY = "ready"  # what a node logs when it is


@dataclass(frozen=True)
class Trips:
    """One run: round trips, s, the periods from sample to sample, s, and what was missed.

    A tick is missed if its sample did not go out before the next one was due, or if no answer came
    before the next sample: that is when the plant takes the newest command.
    """

    round_trips: Array
    periods: Array
    unsent: float  # share of the ticks
    unanswered: float  # share of the ticks, of those that were sent

    @property
    def missed(self) -> float:
        """Share of the ticks."""
        return self.unsent + self.unanswered

    @classmethod
    def of(cls, sent: Array, answered: Array, period: float, soonest: float = 0.0) -> Trips:
        """Of the times at which samples went out and answers came, s, in order.

        Answers do not say what they answer. One that comes less than `soonest`, s, after a sample
        answers one before; of the others the first after a sample ends its round trip. What is
        never answered takes until the last sample, which itself does not count: nobody waits for
        its answer. MicrogripperError where no answer came, or the first too late to count from.
        """
        if not len(answered) or sent[-1] - answered[0] < 1.5 * SETTLING:
            raise MicrogripperError("bench: the samples of a loop were not answered")
        counted = sent[sent > answered[0] + SETTLING]
        begin, end = counted[:-1], counted[1:]
        answered = np.append(answered[answered < sent[-1]], sent[-1] + soonest)
        first = answered[np.searchsorted(answered, begin + soonest)]
        ticks = max(len(begin), round(float(end[-1] - begin[0]) / period))
        unsent, late = ticks - len(begin), int(np.sum(first >= end))
        return cls(first - begin, end - begin, unsent / ticks, late / ticks)


def check_ros() -> None:
    """MicrogripperError where there is no ROS 2."""
    if importlib.util.find_spec("rclpy") is None:
        raise MicrogripperError("ROS 2 is not there")


def run_loop(
    folder: Path,
    pair: tuple[str, str],
    duration: float,
    rate: float,
    settings: Mapping[str, Any],
    soonest: float = 0.0,
) -> Trips:
    """Let a pair of nodes answer each other for `duration`, s, at `rate`, Hz.

    `settings` are parameters of both; `soonest` as in `Trips.of`.
    """
    check_ros()
    out = folder / "round_trips.json"
    answering, sending = pair
    length = duration + DISCOVERY + 3.0 * SETTLING
    with Nodes(folder / "log") as nodes:
        own: dict[str, Any] = {"sample_rate": rate} if pair is OURS else {}
        _await_ready(nodes.start(answering, **own, **settings))
        sender = nodes.start(sending, out=out, duration=length, sample_rate=rate, **settings)
        nodes.wait_for(sender, STARTING + 3.0 * length)
    times = json.loads(out.read_text(encoding="utf-8"))
    return Trips.of(np.array(times["sent"]), np.array(times["answered"]), 1.0 / rate, soonest)


def _await_ready(node: Node) -> None:
    """Wait until a node says so; MicrogripperError if it ends or does not."""
    end = time.monotonic() + STARTING
    while READY not in node.log.read_text(encoding="utf-8", errors="replace"):
        node.check()
        if time.monotonic() > end:
            raise MicrogripperError(f"bench: node {node.name} was not ready in {STARTING:g} s")
        time.sleep(POLL)
