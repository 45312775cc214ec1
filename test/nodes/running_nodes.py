"""The real nodes as processes, and a node of the test's own that watches them over DDS."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

import microgripper_control

ROOT = Path(microgripper_control.__file__).parents[1]
PATIENCE = 120.0  # s, for anything; only a failing test ever waits so long


class Running:
    """A node's process."""

    def __init__(
        self, name: str, settings: dict[str, Any], folder: Path, env: dict[str, str]
    ) -> None:
        self.name = name
        given = [f"-p {key}:={json.dumps(value)}".split(" ", 1) for key, value in settings.items()]
        command = [sys.executable, "-m", f"microgripper_control.nodes.{name}"]
        if given:
            command += ["--ros-args", *(word for pair in given for word in pair)]
        env = env | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
        self._log = folder / f"{name}.{time.monotonic_ns()}.log"
        with self._log.open("wb") as log:
            self.process = subprocess.Popen(
                command, cwd=folder, env=env, stdout=log, stderr=subprocess.STDOUT
            )

    @property
    def log(self) -> str:
        """What it has printed so far."""
        return self._log.read_text(encoding="utf-8", errors="replace")

    def until_it_says(self, text: str) -> None:
        """Wait for a text in its log."""
        end = time.monotonic() + PATIENCE
        while text not in self.log:
            assert self.process.poll() is None, f"{self.name} ended: {self.log}"
            assert time.monotonic() < end, f"{self.name} did not say {text!r}"
            time.sleep(0.02)

    def ended(self) -> int:
        """Its exit status, once it has ended by itself."""
        return self.process.wait(PATIENCE)

    def stop(self, number: int = signal.SIGINT) -> int:
        """Its exit status, after a signal."""
        self.process.send_signal(number)
        return self.ended()


Start = Callable[..., Running]  # start("controller", kp=5)


class Watcher:
    """A node of the test's own, in the nodes' namespace."""

    def __init__(self) -> None:
        self._context = Context()
        self._context.init(args=[])
        self.node = Node("watcher", context=self._context, namespace="microgripper")
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def until(self, condition: Callable[[], bool], what: str) -> None:
        """Handle what comes until the condition holds."""
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, f"waited in vain for {what}"
            self._executor.spin_once(timeout_sec=0.02)

    def messages(self, kind: type, topic: str) -> list[Any]:
        """A list that fills with the messages of a topic."""
        found: list[Any] = []
        self.node.create_subscription(kind, topic, found.append, QoSProfile(depth=5000))
        return found

    def publisher(self, kind: type, topic: str) -> Publisher:
        """A publisher somebody listens to, on both sides of which the other is known."""
        publisher = self.node.create_publisher(kind, topic, QoSProfile(depth=5000))
        self.until(lambda: publisher.get_subscription_count() > 0, f"a subscriber to {topic}")
        return publisher

    def published(self, topic: str) -> None:
        """Wait until somebody publishes a topic."""
        self.until(lambda: self.node.count_publishers(topic) > 0, f"a publisher of {topic}")

    def call(self, kind: type, service: str, request: object) -> Any:  # noqa: ANN401
        """The answer of a service."""
        client = self.node.create_client(kind, service)
        self.until(client.service_is_ready, f"the service {service}")
        answer = client.call_async(request)
        self.until(answer.done, f"an answer of {service}")
        return answer.result()

    def close(self) -> None:
        """Leave the domain."""
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
