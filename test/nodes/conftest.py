"""Starts nodes for the tests, and ends them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from running_nodes import PATIENCE, Running, Start, Watcher


@pytest.fixture
def start(ros_domain: dict[str, str], tmp_path: Path) -> Iterator[Start]:
    """`start("controller", kp=5)` starts a node; none outlives the test."""
    running: list[Running] = []

    def start(name: str, **settings: object) -> Running:
        running.append(Running(name, settings, tmp_path, ros_domain))
        return running[-1]

    yield start
    for one in running:
        if one.process.poll() is None:
            one.process.kill()
        one.process.wait(PATIENCE)
        print(f"--- {one.name}, exit status {one.process.returncode}\n{one.log}")


@pytest.fixture
def watcher(ros_domain: dict[str, str]) -> Iterator[Watcher]:
    watcher = Watcher()
    yield watcher
    watcher.close()


@pytest.fixture
def ros(ros_domain: dict[str, str]) -> Iterator[Callable[..., None]]:
    """`ros("--ros-args", ...)` prepares rclpy for a node made in the test itself."""

    def init(*args: str) -> None:
        rclpy.try_shutdown()
        rclpy.init(args=list(args))

    yield init
    rclpy.try_shutdown()
