"""Nodes as processes of their own, and no process left behind.

They run with the same interpreter, in a DDS domain of their own that does not leave this machine: a
demo must never move somebody's real gripper. Each is in a session of its own, so that Ctrl-C
reaches the demo alone, which then ends them in order.

While nodes run, what asks the demo to end (`core.ending`) takes effect where they are waited for,
and nowhere else. An interrupt inside `Popen` would lose the process that it starts, and one inside
its `poll` the lock without which no later `wait` returns.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType

from microgripper_control.core.ending import asked_to_end
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.demo.domain import on_this_machine, unused_domain

PATIENCE = 60.0  # s, for a node to end when asked
POLL = 0.02  # s
LOG_LINES = 3  # of a failed node's log, in the error


class Node:
    """One running node; `log` is what it prints."""

    def __init__(self, name: str, words: Sequence[str], log: Path, env: dict[str, str]) -> None:
        self.name = name
        self.log = log
        module = f"microgripper_control.nodes.{name}"
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                [sys.executable, "-m", module, *words],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=env,
                start_new_session=True,
            )

    @property
    def status(self) -> int | None:
        """Exit status; None while it runs."""
        return self._process.poll()

    def ask_to_end(self) -> None:
        """Send SIGINT."""
        if self.status is None:
            self._process.send_signal(signal.SIGINT)

    def end(self) -> None:
        """Ask it to end and wait; kill it if it does not."""
        self.ask_to_end()
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def check(self) -> None:
        """Raise MicrogripperError, with the end of its log, if it ended with an error."""
        if self.status:
            text = self.log.read_text(encoding="utf-8", errors="replace")
            said = " | ".join(text.strip().splitlines()[-LOG_LINES:])
            raise MicrogripperError(f"node {self.name} ended with status {self.status}: {said}")


class Nodes:
    """A set of running nodes; leaving the context ends all of them.

    Within the context what asks to end raises KeyboardInterrupt from `wait_for` and at its end.
    """

    def __init__(self, log_folder: Path) -> None:
        log_folder.mkdir(parents=True, exist_ok=True)
        self._logs = log_folder
        self._running: list[Node] = []
        self._env: dict[str, str] = {}
        self._interrupts: list[int] = []
        self._around = ExitStack()

    def __enter__(self) -> Nodes:
        domain = self._around.enter_context(unused_domain())
        self._interrupts = self._around.enter_context(_interrupts_held_back())
        self._env = on_this_machine(domain) | {"ROS_LOG_DIR": str(self._logs / "ros")}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # The last started depend on the first: the plant goes last.
        with self._around:
            for node in reversed(self._running):
                node.end()

    def start(self, name: str, *files: Path, label: str = "", **parameters: object) -> Node:
        """Start a node with parameters and parameter files."""
        words = ["--ros-args"]
        for file in files:
            words += ["--params-file", str(file)]
        for key, value in parameters.items():
            # rcl reads YAML, of which JSON is a part: a path with a # in it stays whole.
            words += ["-p", f"{key}:={json.dumps(value, default=str, ensure_ascii=False)}"]
        node = Node(name, words, self._logs / f"{label or name}.log", self._env)
        self._running.append(node)
        return node

    def wait_for(self, node: Node, timeout: float) -> None:
        """Wait until a node ends by itself; an error if it, or another one, fails."""
        deadline = time.monotonic() + timeout
        while node.status is None:
            if self._interrupts:
                raise KeyboardInterrupt
            for other in self._running:
                other.check()
            if time.monotonic() > deadline:
                raise MicrogripperError(
                    f"node {node.name} did not end within {timeout:g} s; see {node.log}"
                )
            time.sleep(POLL)
        node.check()

    def end(self, node: Node) -> None:
        """End one node now; an error if it fails at that."""
        node.end()
        node.check()
        self._running.remove(node)


@contextmanager
def _interrupts_held_back() -> Iterator[list[int]]:
    """What asks to end takes effect when the context does; until then it is in the list."""
    held: list[int] = []
    try:
        with asked_to_end() as held:
            yield held
    finally:
        if held:
            signal.raise_signal(held[0])
