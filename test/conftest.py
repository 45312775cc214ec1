"""What the tests share."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from microgripper_control.demo.domain import DISCOVERY_VARIABLES, unused_domain

settings.register_profile("chaos", max_examples=500, deadline=None)


@pytest.fixture
def hangup() -> Iterator[None]:
    """SIGHUP is not ignored, as it is by tests that `nohup` has started, and by their processes.

    Whatever becomes of it in a test, it is as it was after it.
    """
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture
def ros_domain(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[dict[str, str]]:
    """Put this test into a ROS domain of its own, on this machine alone.

    The environment for the test's processes; rclpy in the test's own process sees it as well.
    """
    with unused_domain() as domain:
        for variable in DISCOVERY_VARIABLES:
            monkeypatch.delenv(variable, raising=False)
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "ros_log"))
        yield dict(os.environ)
