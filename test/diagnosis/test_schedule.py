"""Work sent to a real Dask scheduler and worker on this machine, and to one that is not there."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.diagnosis.search.schedule import cluster, side_by_side

PATIENCE = 120.0  # s


def square(number: int) -> int:
    return number * number


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """Of a scheduler with one worker."""
    file = tmp_path / "scheduler.json"
    commands = (
        ["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"],
        ["worker", "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"],
    )
    processes = [
        subprocess.Popen(
            [sys.executable, "-m", "dask", *command, "--scheduler-file", str(file)],
            cwd=tmp_path,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for command in commands
    ]
    try:
        end = time.monotonic() + PATIENCE
        while not (file.exists() and file.read_text()):
            assert time.monotonic() < end, "the scheduler does not start"
            assert all(process.poll() is None for process in processes)
            time.sleep(0.1)
        yield str(json.loads(file.read_text())["address"])
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_a_cluster_does_the_same_work(address: str) -> None:
    tasks = [(number,) for number in range(12)]
    with cluster(address):
        found = sorted(side_by_side(square, tasks, -1))
    assert found == [number * number for number in range(12)]


def test_nobody_at_the_address_is_one_clear_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("microgripper_control.diagnosis.search.schedule.PATIENCE", 0.5)
    with (
        pytest.raises(MicrogripperError, match=r"^--scheduler tcp://127\.0\.0\.1:9: "),
        cluster("tcp://127.0.0.1:9"),
    ):
        pytest.fail("there is nobody")
