"""No process is lost, whenever the interrupt comes."""

from __future__ import annotations

import os
import signal
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.demo import processes
from microgripper_control.demo.processes import Node, Nodes


def test_an_interrupt_while_a_process_starts_still_ends_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[Node] = []

    def interrupted(*arguments: object) -> Node:
        node = Node(*arguments)  # type: ignore[arg-type]
        started.append(node)
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.01)
        return node

    monkeypatch.setattr(processes, "Node", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), Nodes(tmp_path) as nodes:
            nodes.start("recorder", out=tmp_path / "bag")
    finally:
        signal.signal(signal.SIGINT, before)
    assert [node.status is not None for node in started] == [True]


def test_an_interrupt_while_a_node_is_asked_how_it_is_does_not_reach_inside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Raised inside `Popen.poll` it would leave a lock taken, and the node's end never come."""
    reached: list[BaseException] = []
    status = Node.status.fget
    assert status is not None

    def interrupted(node: Node) -> int | None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt as error:
            reached.append(error)
            raise
        return status(node)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with ExitStack() as context:
            nodes = context.enter_context(Nodes(tmp_path))
            node = nodes.start("recorder", out=tmp_path / "bag")
            monkeypatch.setattr(Node, "status", property(interrupted))
            with pytest.raises(KeyboardInterrupt):
                nodes.wait_for(node, 60.0)
            with pytest.raises(KeyboardInterrupt):
                context.close()
    finally:
        signal.signal(signal.SIGINT, before)
    monkeypatch.undo()
    assert reached == []
    assert node.status is not None


def test_a_node_that_fails_is_named_with_what_it_said(tmp_path: Path) -> None:
    with Nodes(tmp_path) as nodes:
        node = nodes.start("plant_simulator", sample_rate=-1.0)
        with pytest.raises(MicrogripperError, match=r"plant_simulator ended .*sample_rate"):
            nodes.wait_for(node, 60.0)
