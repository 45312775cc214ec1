"""The readable part with a warning, or one clear line: never a traceback, never silent loss."""

from __future__ import annotations

import shutil
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import yaml
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
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.bag_writer import STORAGES, BagWriter
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.repair import repair_bag
from microgripper_control.recordings.sqlite import SqliteFile
from microgripper_control.recordings.write import write_bag


@pytest.fixture(scope="module", params=STORAGES)
def bag(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "run"
    write_bag(path, RECORDING, request.param)
    return path


def complaint(path: Path) -> str:
    with pytest.raises(MicrogripperError) as caught:
        read_recording(path)
    check_line(str(caught.value), path)
    return str(caught.value)


def test_a_bag_cut_off_anywhere(bag: Path, tmp_path: Path) -> None:
    whole = storage_file(bag).read_bytes()
    readable = []
    for cut in [*range(0, len(whole), 307), len(whole) - 1]:
        path = damaged(bag, tmp_path, whole[:cut])
        recording = recording_or_complaint(path)
        if recording is None:
            continue
        count = len(recording)
        readable.append(count)
        assert agrees(recording)
        assert any(storage_file(path).name in warning for warning in recording.warnings)
        lost = f"/microgripper/joint_states: {count} of {COUNT} messages are there"
        assert (lost in recording.warnings) == (count < COUNT)
    assert readable == sorted(readable)
    # MCAP's messages are the file; SQLite's tables come first, then the messages in pages of 4 KiB.
    assert len(readable) * 307 > 0.5 * len(whole)
    assert readable[-1] >= COUNT - 25


@settings(
    deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_bytes_that_changed(bag: Path, tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray(storage_file(bag).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    recording_or_complaint(damaged(bag, tmp_path, bytes(content)))


@pytest.mark.parametrize(
    "content", [b"", b"\0" * 5000, b"text", b"\x89MCAP0\r\n", b"SQLite format 3\0"]
)
def test_a_storage_file_that_is_none(bag: Path, tmp_path: Path, content: bytes) -> None:
    complaint(damaged(bag, tmp_path, content))


NEWEST = 2**63 - 1


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE messages SET data = 5 WHERE id = 60",
        "UPDATE messages SET data = 'text' WHERE id = 60",
        "UPDATE messages SET data = x'' WHERE id = 60",
        "UPDATE messages SET data = zeroblob(1000000) WHERE id = 60",
        "UPDATE messages SET timestamp = 'x' WHERE id = 60",
        f"UPDATE messages SET id = {NEWEST} WHERE id = 400",
        "UPDATE messages SET topic_id = 99 WHERE id = 60",
        "DELETE FROM messages WHERE id > 30",
        "DELETE FROM topics WHERE id = 2",
        "UPDATE topics SET name = x'ff0a' WHERE id = 2",
        "UPDATE topics SET type = 5",
        "UPDATE topics SET serialization_format = 'json'",
        "UPDATE topics SET offered_qos_profiles = '[: {'",
        f"UPDATE messages SET timestamp = {NEWEST} WHERE id = 60",
        "UPDATE messages SET timestamp = -5 WHERE id = 60",
        "UPDATE message_definitions SET encoded_message_definition = 7",
        "UPDATE metadata SET metadata = x'ff'",
        "DROP TABLE messages",
        "DROP TABLE metadata",
    ],
)
def test_a_database_of_anything(tmp_path: Path, statement: str) -> None:
    """Values of other types and rows that are gone; what is lost is told, and repaired."""
    path = tmp_path / "run"
    write_bag(path, RECORDING, "sqlite3")
    with closing(sqlite3.connect(storage_file(path))) as database, database:
        database.execute(statement)
    found = recording_or_complaint(path)
    whole = found is not None and len(found) == COUNT and found.setpoint is not None
    assert whole or found is None or found.warnings
    try:
        repair_bag(path)
    except MicrogripperError as error:
        check_line(str(error), path)
        return
    again = recording_or_complaint(path)
    assert (again is None) == (found is None)
    assert found is None or (again is not None and len(again) == len(found))


def test_a_file_system_that_lost_the_end(bag: Path, tmp_path: Path) -> None:
    """After a power cut the length may be there and the content not."""
    whole = storage_file(bag).read_bytes()
    half = 4096 * (len(whole) // 4096 * 3 // 4)
    recording = read_recording(damaged(bag, tmp_path, whole[:half] + b"\0" * (len(whole) - half)))
    count = len(recording)
    assert 20 < count < COUNT
    assert np.array_equal(recording.voltage, RECORDING.voltage[:count])
    assert recording.warnings


def test_metadata_cut_off_anywhere(bag: Path, tmp_path: Path) -> None:
    path = damaged(bag, tmp_path, storage_file(bag).read_bytes())
    whole = (path / "metadata.yaml").read_bytes()
    for cut in range(0, len(whole) - 1, 37):
        (path / "metadata.yaml").write_bytes(whole[:cut])
        recording = read_recording(path)
        assert np.array_equal(recording.voltage, RECORDING.voltage)
        assert recording.warnings == (
            "metadata.yaml is missing or damaged; the storage files were read",
        )


def test_a_definition_that_changed_in_the_summary_is_told(tmp_path: Path) -> None:
    """The one beside the messages, which a checksum guards, is not the same."""
    path = tmp_path / "run"
    write_bag(path, RECORDING)
    before, fields, after = storage_file(path).read_bytes().rpartition(b"float64[] effort")
    storage_file(path).write_bytes(before + fields.replace(b"64", b"32") + after)
    recording = recording_or_complaint(path)
    assert recording is None or any("is damaged" in line for line in recording.warnings)


def test_without_metadata(bag: Path, tmp_path: Path) -> None:
    path = damaged(bag, tmp_path, storage_file(bag).read_bytes())
    (path / "metadata.yaml").unlink()
    assert len(read_recording(path)) == COUNT


def test_without_the_listed_file(bag: Path, tmp_path: Path) -> None:
    path = damaged(bag, tmp_path, b"x")
    name = storage_file(path).name
    storage_file(path).unlink()
    assert complaint(path) == f"{path}: metadata.yaml lists {name}: not there"


def test_a_storage_file_that_the_metadata_does_not_list_is_told(bag: Path, tmp_path: Path) -> None:
    path = damaged(bag, tmp_path, storage_file(bag).read_bytes())
    shutil.copy(storage_file(path), path / "more.mcap")
    assert read_recording(path).warnings == (
        "more.mcap is in the folder but not listed in metadata.yaml: not read",
    )


def test_a_storage_file_that_has_another_name(bag: Path, tmp_path: Path) -> None:
    path = damaged(bag, tmp_path, storage_file(bag).read_bytes())
    name = storage_file(path).name
    storage_file(path).rename(path / f"good {name}")
    assert complaint(path) == (
        f"{path}: metadata.yaml lists {name}: not there; remove metadata.yaml to read good {name}"
    )
    (path / "metadata.yaml").unlink()
    assert len(read_recording(path)) == COUNT


def test_messages_that_were_never_committed(bag: Path, tmp_path: Path) -> None:
    """The storage file is whole, but has less than the metadata says."""
    path = damaged(bag, tmp_path, storage_file(bag).read_bytes())
    metadata = path / "metadata.yaml"
    metadata.write_text(
        metadata.read_text().replace(f"- message_count: {COUNT}", "- message_count: 900")
    )
    assert read_recording(path).warnings == (
        f"/microgripper/joint_states: {COUNT} of 900 messages are there",
        f"/microgripper/setpoint: {COUNT} of 900 messages are there",
    )


@pytest.mark.parametrize("way_out", ["../", "x/../../", "{}/", "C:\\", "..\\"])
def test_a_path_in_the_metadata_does_not_lead_out(bag: Path, tmp_path: Path, way_out: str) -> None:
    path = damaged(bag, tmp_path, storage_file(bag).read_bytes())
    metadata = path / "metadata.yaml"
    name = storage_file(path).name
    shutil.move(storage_file(path), tmp_path / name)
    listed = way_out.format(tmp_path) + name
    for mode in ("", "file"):  # the library reads compressed ones
        told = yaml.safe_load(metadata.read_text())
        told["rosbag2_bagfile_information"] |= {
            "relative_file_paths": [listed],
            "compression_mode": mode,
        }
        metadata.write_text(yaml.safe_dump(told))
        assert "outside of the bag; not followed" in complaint(path)


@pytest.mark.parametrize("storage", STORAGES)
def test_a_recorder_that_was_killed_after_a_flush(tmp_path: Path, storage: str) -> None:
    """What the files hold after a flush is all that a killed process leaves."""
    write_bag(tmp_path / "whole", RECORDING, storage)
    with BagWriter(tmp_path / "run", storage) as writer:
        copy_messages(tmp_path / "whole", writer, 150)
        writer.flush()
        shutil.copytree(tmp_path / "run", tmp_path / "killed")
        before = files_in(tmp_path / "killed")
    recording = read_recording(tmp_path / "killed")
    assert np.array_equal(recording.voltage, RECORDING.voltage[:150])
    assert len(recording.warnings) == 2
    assert "not closed" in recording.warnings[1]
    assert files_in(tmp_path / "killed") == before, "reading changed the recording"
    assert read_recording(tmp_path / "run").warnings == ()


def copy_messages(source: Path, writer: BagWriter, samples: int) -> None:
    with Bag(source) as bag:
        for topic in bag.topics:
            writer.add_topic(topic.name, topic.type)
        for index, (topic, at, content) in enumerate(bag.messages(bag.topics)):
            if index == 2 * samples:
                return
            writer.write(topic.name, at, content)


def test_a_temporary_folder_that_is_not_there_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was not closed is read from a copy."""
    write_bag(tmp_path / "run", RECORDING, "sqlite3")
    (tmp_path / "run" / "run.db3-wal").write_bytes(b"x")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    line = complaint(tmp_path / "run")
    assert f"cannot be made: No such file or directory ({tmp_path / 'gone'}" in line
    assert "set TMPDIR to a folder that can be written" in line


def test_functions_that_a_database_names_itself_are_not_trusted(tmp_path: Path) -> None:
    """It may name some in its schema, to be called by whoever reads it."""
    write_bag(tmp_path / "run", RECORDING, "sqlite3")
    file = SqliteFile(storage_file(tmp_path / "run"))
    trusted = file._database.execute("PRAGMA trusted_schema").fetchone()
    file.close()
    assert trusted == (0,)


def test_folders_and_files_that_are_no_bags(tmp_path: Path) -> None:
    assert "is not a rosbag2: no metadata.yaml and no .mcap or .db3 file" in complaint(tmp_path)
    (tmp_path / "old.bag").write_bytes(b"#ROSBAG V2.0\n")
    assert "is a bag of ROS 1; convert it with rosbags-convert" in complaint(tmp_path / "old.bag")
    (tmp_path / "a.mcap").write_bytes(b"")
    assert "is empty" in complaint(tmp_path / "a.mcap")
    (tmp_path / "b.mcap").write_bytes(b"something else")
    assert "is neither MCAP nor SQLite: not a rosbag2" in complaint(tmp_path / "b.mcap")
    sqlite3.connect(tmp_path / "c.db3").execute("CREATE TABLE notes (text)").connection.close()
    assert "is an SQLite file but no rosbag2" in complaint(tmp_path / "c.db3")
    assert "does not exist" in complaint(tmp_path / "d")
