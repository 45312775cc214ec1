"""What the last second before the end of the recorder or of the disk's room leaves."""

from __future__ import annotations

import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from running_nodes import PATIENCE, Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.bag_writer import STORAGES
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.repair import repair_bag

pytestmark = pytest.mark.ros

MOST_LOST = 1.0  # s
ROOM = 600_000  # bytes: full after about two seconds


class Rig:
    """Publishes numbered samples, setpoints and commands at 1 kHz until it is stopped."""

    def __init__(self, watcher: Watcher) -> None:
        self._states = watcher.publisher(JointState, "joint_states")
        self._others = [
            watcher.publisher(Float64, topic) for topic in ("setpoint", "voltage_command")
        ]
        self.published: list[float] = []  # when each sample was, s
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        state = JointState(name=["finger"], position=[0.0], velocity=[0.0], effort=[0.0])
        begin = time.monotonic()
        while not self._stopped.is_set():
            tick = len(self.published)
            state.header.stamp.sec, rest = divmod(tick, 1000)
            state.header.stamp.nanosec = 1_000_000 * rest
            state.position[0], state.effort[0] = 1e-6 * tick, float(tick)
            self._states.publish(state)
            self.published.append(time.monotonic())
            for publisher in self._others:
                publisher.publish(Float64(data=float(tick)))
            time.sleep(max(0.0, begin + 1e-3 * (tick + 1) - time.monotonic()))

    def stop(self) -> None:
        self._stopped.set()
        self._thread.join()


@pytest.fixture
def rigs() -> Iterator[list[Rig]]:
    running: list[Rig] = []
    yield running
    for rig in running:
        rig.stop()


@pytest.fixture
def full_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system with room for two seconds."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={ROOM}", "tmpfs", place], capture_output=True
    )
    if mounted.returncode:
        pytest.skip(f"no small disk can be mounted here: {mounted.stderr.decode().strip()}")
    yield place
    subprocess.run(["umount", "-l", place], check=True)


def check_numbers(bag: Path) -> int:
    """Whether the samples are the first ones that were published, without a gap; their number."""
    recording = read_recording(bag)
    np.testing.assert_array_equal(recording.voltage, np.arange(float(len(recording))))
    np.testing.assert_array_equal(recording.measured, 1e-6 * np.arange(float(len(recording))))
    return len(recording)


@pytest.mark.parametrize("length", [1.5, 1.7, 1.9])  # at any phase between two flushes
@pytest.mark.parametrize("storage", STORAGES)
def test_a_recorder_that_is_killed_loses_less_than_a_second(
    start: Start, watcher: Watcher, rigs: list[Rig], tmp_path: Path, storage: str, length: float
) -> None:
    recorder = start("recorder", out="bag", storage=storage)
    rig = Rig(watcher)
    rigs.append(rig)
    watcher.until(lambda: len(rig.published) > 1000 * length, "samples")
    recorder.process.kill()
    killed = time.monotonic()
    recorder.process.wait(PATIENCE)
    rig.stop()
    kept = check_numbers(tmp_path / "bag")
    print(f"{storage}: {killed - rig.published[kept]:.3f} s lost")
    assert killed - rig.published[kept] < MOST_LOST
    assert read_recording(tmp_path / "bag").warnings

    repair_bag(tmp_path / "bag")
    assert check_numbers(tmp_path / "bag") == kept
    assert read_recording(tmp_path / "bag").warnings == ()


@pytest.mark.parametrize("storage", STORAGES)
def test_a_full_disk_loses_nothing_that_was_on_it(
    start: Start, watcher: Watcher, rigs: list[Rig], full_disk: Path, storage: str
) -> None:
    bag = full_disk / "bag"
    recorder = start("recorder", out=str(bag), storage=storage)
    rigs.append(Rig(watcher))
    assert recorder.ended() == 2
    ended = time.monotonic()
    rig = rigs[-1]
    rig.stop()
    last = recorder.log.strip().rsplit("\n", 1)[-1]
    assert last.startswith(f"recorder: {bag}: cannot be written: ")
    assert "full" in last or "No space left" in last
    assert "Traceback" not in recorder.log
    kept = check_numbers(bag)
    print(f"{storage}: {kept} samples, {ended - rig.published[kept]:.3f} s before the end")
    assert ended - rig.published[kept] < MOST_LOST

    before = {file.name: file.read_bytes() for file in bag.iterdir()}
    with pytest.raises(MicrogripperError, match=r"cannot be (written|repaired)"):
        repair_bag(bag)
    assert {file.name: file.read_bytes() for file in bag.iterdir()} == before
    subprocess.run(["mount", "-o", f"remount,size={8 * ROOM}", full_disk], check=True)
    repair_bag(bag)
    assert check_numbers(bag) == kept
    assert read_recording(bag).warnings == ()


@pytest.mark.parametrize("storage", STORAGES)
def test_a_limit_on_the_size_of_files(
    start: Start, watcher: Watcher, rigs: list[Rig], tmp_path: Path, storage: str
) -> None:
    """As a full disk or a quota, where no disk can be mounted."""
    recorder = start("recorder", out="bag", storage=storage)
    recorder.until_it_says("starting")
    pid = recorder.process.pid
    subprocess.run(["prlimit", f"--pid={pid}", f"--fsize={ROOM // 2}"], check=True)
    rigs.append(Rig(watcher))
    assert recorder.ended() == 2
    assert "cannot be written" in recorder.log
    assert check_numbers(tmp_path / "bag") > 0
