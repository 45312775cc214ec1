"""A repaired bag is whole, has all that could be read, and nothing was ever at stake."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from bag_messages import FLOAT64, QUALITY, STORE, samples, write
from bags_to_break import (
    COUNT,
    RECORDING,
    agrees,
    check_line,
    damaged,
    files_in,
    recording_or_complaint,
    storage_file,
)
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import CompressionMode

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings import repair
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.bag_writer import STORAGES, BagWriter
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.repair import repair_bag
from microgripper_control.recordings.write import write_bag

TOPICS = ("/microgripper/joint_states", "/microgripper/setpoint")
ONE = bytes(STORE.serialize_cdr(STORE.types[FLOAT64](1.0), FLOAT64))
DEFINITION = f"float64 a\nmy_rig/In in\n{80 * '='}\nMSG: my_rig/In\nint32 b\n"
QOS = QUALITY.format("best_effort")


@pytest.fixture(scope="module", params=STORAGES)
def bag(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "run"
    write_bag(path, RECORDING, request.param)
    return path


@pytest.fixture
def broken(bag: Path, tmp_path: Path) -> Path:
    """Cut off in the last quarter, without metadata."""
    whole = storage_file(bag).read_bytes()
    path = damaged(bag, tmp_path, whole[: len(whole) * 3 // 4])
    (path / "metadata.yaml").unlink()
    return path


def read_by_the_library(path: Path) -> dict[str, int]:
    """Messages by topic, which rosbags finds by the index and the metadata alone."""
    with AnyReader([path]) as reader:
        found = {connection.topic: connection.msgcount for connection in reader.connections}
        assert sum(1 for _ in reader.messages()) == sum(found.values())
    return found


def complaint(path: Path) -> str:
    with pytest.raises(MicrogripperError) as caught:
        repair_bag(path)
    check_line(str(caught.value), path)
    return str(caught.value)


def nothing_left_beside(path: Path, *others: str) -> None:
    assert {file.name for file in path.parent.iterdir()} == {path.name, *others}


def test_what_could_be_read_is_in_a_whole_bag(broken: Path) -> None:
    before = files_in(broken)
    read = read_recording(broken)
    with pytest.raises(Exception, match=r".*"), AnyReader([broken]):
        pass  # the library refuses it
    done = repair_bag(broken)
    found = read_recording(broken)
    assert found.warnings == ()
    assert agrees(found)
    assert np.array_equal(found.voltage, read.voltage)
    assert np.array_equal(found.setpoint, read.setpoint)
    assert read_by_the_library(broken) == done.messages
    assert done.messages[TOPICS[0]] == len(read) > COUNT // 2
    assert any(storage_file(broken).name in lost for lost in done.lost)
    assert done.kept is not None
    assert files_in(done.kept) == before
    nothing_left_beside(broken, done.kept.name)


def test_a_bag_cut_off_anywhere_is_whole_afterwards(bag: Path, tmp_path: Path) -> None:
    whole = storage_file(bag).read_bytes()
    repaired = 0
    for cut in [*range(1, len(whole), 2503), len(whole) - 1]:
        path = damaged(bag, tmp_path, whole[:cut])
        before = files_in(path)
        read = recording_or_complaint(path)
        try:
            done = repair_bag(path)
        except MicrogripperError as error:
            check_line(str(error), path)
            assert files_in(path) == before
            continue
        repaired += 1
        assert done.kept is not None
        assert done.lost
        assert files_in(done.kept) == before
        assert read_by_the_library(path) == done.messages
        if read is not None:
            assert np.array_equal(read_recording(path).voltage, read.voltage)
        shutil.rmtree(path)
        done.kept.rename(path)
    assert repaired > 4


def test_again_changes_nothing(broken: Path) -> None:
    repair_bag(broken)
    before = files_in(broken.parent)
    done = repair_bag(broken)
    assert done.kept is None
    assert done.lost == ()
    assert files_in(broken.parent) == before


def test_a_whole_bag_is_left_alone(bag: Path) -> None:
    before = files_in(bag.parent)
    done = repair_bag(bag)
    assert (done.kept, done.messages) == (None, dict.fromkeys(TOPICS, COUNT))
    assert files_in(bag.parent) == before


def test_metadata_alone(bag: Path, tmp_path: Path) -> None:
    path = damaged(bag, tmp_path, storage_file(bag).read_bytes())
    (path / "metadata.yaml").write_text("rosbag2_bagfile_information:\n  vers")
    assert repair_bag(path).messages == dict.fromkeys(TOPICS, COUNT)
    assert read_by_the_library(path) == dict.fromkeys(TOPICS, COUNT)


def test_several_files_become_one(tmp_path: Path) -> None:
    """A recorder that splits its bag: each file has a part of the messages."""
    for number, part in enumerate((slice(0, 100), slice(100, 200))):
        measured = RECORDING.measured[part]
        start = 1e-3 * 100 * number
        write_bag(
            tmp_path / f"run_{number}",
            type(RECORDING)("run", 1e-3, RECORDING.voltage[part], measured, start=start),
        )
        (tmp_path / "run").mkdir(exist_ok=True)
        shutil.move(storage_file(tmp_path / f"run_{number}"), tmp_path / "run")
    repair_bag(tmp_path / "run")
    found = read_recording(tmp_path / "run")
    assert len(found) == COUNT
    assert agrees(found)


@pytest.mark.parametrize("storage", STORAGES)
def test_quality_of_service_and_foreign_types_stay(tmp_path: Path, storage: str) -> None:
    kind = "my_rig/msg/Sample"
    with BagWriter(tmp_path / "run", storage) as writer:
        writer.add_topic("/rig", kind, QOS, definition=DEFINITION)
        for at in range(20):
            writer.write("/rig", at, ONE)
    told = yaml.safe_load((tmp_path / "run" / "metadata.yaml").read_text())
    (tmp_path / "run" / "metadata.yaml").unlink()
    assert repair_bag(tmp_path / "run").messages == {"/rig": 20}
    again = yaml.safe_load((tmp_path / "run" / "metadata.yaml").read_text())
    assert again == told
    with Bag(tmp_path / "run") as bag:
        assert "int32 b" in bag.topics[0].definition
        assert [at for _, at, _ in bag.messages(bag.topics)] == list(range(20))


def test_while_it_is_recorded(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "run") as writer:
        writer.add_topic("/setpoint", FLOAT64)
        writer.write("/setpoint", 5, ONE)
        writer.flush()
        assert "is being written; stop the recorder first" in complaint(tmp_path / "run")
    assert read_by_the_library(tmp_path / "run") == {"/setpoint": 1}


def test_an_original_is_not_overwritten(broken: Path) -> None:
    kept = repair_bag(broken).kept
    assert kept is not None
    original = files_in(kept)
    (broken / "metadata.yaml").unlink()
    assert "the original of an earlier repair; move it away" in complaint(broken)
    assert files_in(kept) == original
    nothing_left_beside(broken, kept.name)


Step = Callable[[Path, Path], Path]


@pytest.mark.parametrize("failing", [1, 2])
def test_a_step_that_fails_changes_nothing(
    broken: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    before = files_in(broken.parent)
    rename, calls = Path.rename, []

    def fails(path: Path, target: Path) -> Path:
        calls.append(path)
        if len(calls) == failing:
            raise PermissionError(1, "Operation not permitted")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", fails)
    assert "cannot be repaired: Operation not permitted" in complaint(broken)
    assert files_in(broken.parent) == before


def test_cut_off_between_the_last_two_steps(broken: Path) -> None:
    """The machine went down when the damaged bag had another name and the new one not yet its."""
    broken.rename(broken.with_name("run.damaged"))
    done = repair_bag(broken)
    assert done.kept is not None
    assert read_by_the_library(broken) == done.messages


def test_killed_anywhere(broken: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The process ends at each of its calls of the disk in turn; the bag is there all the time."""
    read = read_recording(broken)
    steps = 0
    while True:
        pid = os.fork()
        if pid == 0:
            _die_at(steps)
            repair_bag(broken)
            os._exit(0)
        _, status = os.waitpid(pid, 0)
        if os.waitstatus_to_exitcode(status) == 0:
            break
        steps += 1
        places = [path for path in (broken, broken.with_name("run.damaged")) if path.exists()]
        assert all(np.array_equal(read_recording(p).voltage, read.voltage) for p in places)
    assert steps >= 6  # three synchronised, two renamed, their folder synchronised
    nothing_left_beside(broken, "run.damaged")
    assert np.array_equal(read_recording(broken).voltage, read.voltage)
    assert read_recording(broken).warnings == ()


def _die_at(step: int) -> None:
    """Let this process end at a certain one of its calls."""
    left = [step]

    def deadly(call: Callable[..., object]) -> Callable[..., object]:
        def made(*given: object) -> object:
            if left[0] == 0:
                os._exit(9)
            left[0] -= 1
            return call(*given)

        return made

    Path.rename = deadly(Path.rename)  # type: ignore[method-assign]
    repair._sync = deadly(repair._sync)  # type: ignore[assignment]


@pytest.mark.parametrize("storage", STORAGES)
def test_compressed_messages_are_not_taken_for_plain_ones(tmp_path: Path, storage: str) -> None:
    """Their recorder was killed before it wrote the metadata, which would say so."""
    path = write(tmp_path / "run", samples(), storage, CompressionMode.MESSAGE)
    (path / "metadata.yaml").unlink()
    before = files_in(tmp_path)
    assert "its messages are compressed by rosbag2; decompress them first" in complaint(path)
    assert files_in(tmp_path) == before
    with pytest.raises(MicrogripperError, match="in message 0 is compressed by rosbag2, and no "):
        read_recording(path)


def test_folders_and_files_that_cannot_be_repaired(tmp_path: Path) -> None:
    assert "does not exist" in complaint(tmp_path / "a")
    (tmp_path / "b.mcap").write_bytes(b"x")
    assert "is one file of a bag; give its folder" in complaint(tmp_path / "b.mcap")
    (tmp_path / "c").mkdir()
    assert "is not a rosbag2" in complaint(tmp_path / "c")
    assert list((tmp_path / "c").iterdir()) == []
