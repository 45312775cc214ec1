"""What all nodes share: starting, spinning, signals, health, ending with an exit status.

rclpy's own signal handlers end its context at once, and with it every publisher: nothing could
bring the voltage down any more. So the signals are taken here, and the executor returns often
enough to notice them.

The executor is rclpy's EventsExecutor unless the parameter `executor` says otherwise: at 1 kHz it
costs half the processor time of the SingleThreadedExecutor, which makes a new wait set for every
message. docs/performance.md has both.

Fast DDS is asked for UDP alone, unless the user has asked it for something: in its shared memory a
process that is stopped while it holds a lock stops all who publish to it, the rig with its guard,
too (docs/reliability.md).
"""

from __future__ import annotations

import gc
import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args, try_shutdown

from microgripper_control.core.ending import asked_to_end
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.realtime import HIGHEST, go_first
from microgripper_control.nodes.health import PERIOD, Health, Reporter
from microgripper_control.nodes.leaving import end_within, no_longer_than
from microgripper_control.nodes.parameters import (
    accept_whole_numbers,
    declare_number,
    declare_text,
    unknown_parameters,
)
from microgripper_control.nodes.qos import events_of
from microgripper_control.nodes.topics import NAMESPACE
from microgripper_control.nodes.usage import WORDS, usage

SINGLE_THREADED, EVENTS = "single_threaded", "events"
EXECUTORS: dict[str, Callable[[], Executor]] = {SINGLE_THREADED: SingleThreadedExecutor}
try:
    from rclpy.experimental.events_executor import EventsExecutor

    EXECUTORS[EVENTS] = EventsExecutor
except ImportError:  # Jazzy before April 2025
    EXECUTORS[EVENTS] = SingleThreadedExecutor

PRIORITY = Parameter(
    "realtime_priority", "1", 0.0, 0.0, HIGHEST, "of SCHED_FIFO, if permitted; 0: as others"
)
POLL = 0.02  # s: the longest time for which a signal goes unnoticed
PATIENCE = 4.0  # s, with the middleware's end; ros2 launch has 5 before it asks less kindly
FAILED, BAD_INPUT = 1, 2  # exit status
TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"  # the first, and what else decides on them
ASKED = (TRANSPORTS, "FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")


@dataclass(frozen=True)
class Outcome:
    """How a node ended: its exit status and the reason."""

    status: int
    message: str


class Shell(Node):
    """A node that `run` runs."""

    outcome: Outcome | None = None  # set once there is nothing more to do

    def __init__(self, name: str) -> None:
        super().__init__(name, namespace=NAMESPACE)
        self._equip()

    def _equip(self) -> None:
        self.get_logger().info("starting")  # the first log statement takes tens of milliseconds
        accept_whole_numbers(self)
        self.executor_name = declare_text(
            self, "executor", EVENTS, "of rclpy", choices=list(EXECUTORS), read_only=True
        )
        self.priority = int(declare_number(self, PRIORITY, read_only=True))
        self._reporter = Reporter(self)
        self._reported = time.monotonic()

    def value_of(self, name: str) -> Any:  # noqa: ANN401 (of any type)
        """Of a parameter."""
        return self.get_parameter(name).value

    def begin(self) -> None:
        """Called once, before the node is spun."""

    def work(self, now: float) -> float:
        """Do what is due at `now` (s, monotonic clock); return the time until the next call, s."""
        return POLL

    def health(self, elapsed: float) -> Health:
        """The state to report, `elapsed` s after the last report."""
        return Health()

    def leave(self) -> None:
        """Called once, last, while the node can still publish; not where `begin` has failed."""

    def finish(self, message: str) -> None:
        """End with success."""
        self._end(Outcome(0, message))

    def fail(self, message: str) -> None:
        """End with an error that is no one's input: a partner that does not answer."""
        self._end(Outcome(FAILED, message))

    def _end(self, outcome: Outcome) -> None:
        if self.outcome is None:
            self.outcome = outcome

    def report_if_due(self, now: float) -> None:
        """Publish the health once a second."""
        elapsed = now - self._reported
        if elapsed >= PERIOD:
            self._reported = now
            health = self.health(elapsed)
            events = {f"{what}, says the middleware": n for what, n in events_of(self).items()}
            self._reporter.report(replace(health, values={**health.values, **events}))


def run(make: Callable[[], Shell], args: list[str] | None = None) -> NoReturn:
    """Make a node and run it to its end or until it is asked to end; exits the process.

    Exit status: 0 if it did what it was started for or was asked to end, 1 if it failed, 2 on bad
    input, with one line on standard error. With `--help` it only says which parameters it has, with
    those given that it takes: which there are can depend on them.
    """
    status = _run(make, args)
    end_within(PATIENCE, status)
    sys.exit(status)


def _run(make: Callable[[], Shell], args: list[str] | None) -> int:
    with asked_to_end() as asked:
        node, status, own, helping = None, FAILED, args, False
        if not any(name in os.environ for name in ASKED):
            os.environ[TRANSPORTS] = "UDPv4"
        try:
            own = remove_ros_args(sys.argv)[1:] if args is None else remove_ros_args(args)
            helping = any(word in own for word in WORDS)
            if own and not helping:
                raise MicrogripperError(f"unknown argument {own[0]!r:.60}; see --help")
            rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
            node = make()
            if helping:
                print(usage(node))
                return 0
            status = _spin(node, asked)
        except MicrogripperError as error:
            status = _bad_input(node, str(error))
        except (ParameterException, rclpy_implementation.RCLError) as error:
            status = _bad_input(node, str(error))
        finally:
            with no_longer_than(PATIENCE, status):
                if node is not None:
                    node.destroy_node()
                try_shutdown()
    if helping and own != args:  # what is given with it is refused: that has been told
        return _run(make, own)
    return status


def _spin(node: Shell, asked: list[int]) -> int:
    executor = EXECUTORS[node.executor_name]()
    executor.add_node(node)
    for line in unknown_parameters(node):
        node.get_logger().warning(line)
    try:
        node.begin()
        _work(node, executor, asked)
    finally:
        executor.remove_node(node)
        executor.shutdown()
    if node.outcome is None:
        return 0
    if node.outcome.status:
        node.get_logger().error(node.outcome.message)
    else:
        node.get_logger().info(node.outcome.message)
    return node.outcome.status


def _work(node: Shell, executor: Executor, asked: list[int]) -> None:
    """Let a node that has begun work until it is done or asked to end, and then leave."""
    try:
        refusal = go_first(node.priority) if node.priority else None
        if refusal:
            node.get_logger().warning(f"realtime_priority: {refusal}")
        node.get_logger().info("ready")
        gc.freeze()  # the collector need not walk through numba and scipy while samples come
        wait = 0.0
        with suppress(ExternalShutdownException):
            while node.outcome is None and not asked:
                executor.spin_once(timeout_sec=min(wait, POLL))
                now = time.monotonic()
                wait = node.work(now)
                node.report_if_due(now)
    finally:
        node.leave()


def _bad_input(node: Shell | None, message: str) -> int:
    name = node.get_name() if node is not None else Path(sys.argv[0]).stem
    print(f"{name}: {' '.join(message.split())}", file=sys.stderr)
    return BAD_INPUT
