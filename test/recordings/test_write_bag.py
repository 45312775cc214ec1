"""What the package writes is read by the library, which follows rosbag2."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from bag_messages import QUALITY
from rosbags.highlevel import AnyReader

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.recordings.bag_writer import STORAGES, BagWriter
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.write import write_bag

COUNT = 20
FLOAT64 = "std_msgs/msg/Float64"
ONE = b"\0\1\0\0" + np.float64(1.0).tobytes()
QOS = QUALITY.format("reliable")


@pytest.mark.parametrize("storage", STORAGES)
def test_a_recording_as_the_nodes_would_publish_it(tmp_path: Path, storage: str) -> None:
    positions = 1e-6 * np.arange(COUNT) ** 2
    recording = Recording(
        "run", 1e-3, np.arange(COUNT) * 2.0, positions, np.arange(COUNT) * 3.0, start=1.7e9
    )
    write_bag(tmp_path / "run", recording, storage)
    with AnyReader([tmp_path / "run"]) as reader:
        assert {(c.topic, c.msgtype, c.msgcount) for c in reader.connections} == {
            ("/microgripper/joint_states", "sensor_msgs/msg/JointState", COUNT),
            ("/microgripper/setpoint", FLOAT64, COUNT),
        }
        rows = list(reader.messages())
        assert [row[0].topic.rpartition("/")[2] for row in rows] == [
            "joint_states",
            "setpoint",
        ] * COUNT
        connection, at, content = rows[6]
        sample = reader.deserialize(content, connection.msgtype)
        setpoint = reader.deserialize(rows[7][2], rows[7][0].msgtype)
    assert at == 1_700_000_000_003_000_000
    assert (sample.header.stamp.sec, sample.header.stamp.nanosec) == (1_700_000_000, 3_000_000)
    assert sample.name == ["finger"]
    assert sample.position.tolist() == [positions[3]]
    assert sample.velocity.tolist() == pytest.approx([5e-6 / 1e-3])
    assert sample.effort.tolist() == [6.0]
    assert setpoint.data == 9.0


@pytest.mark.parametrize("storage", STORAGES)
def test_samples_that_were_filled_in_are_not_written(tmp_path: Path, storage: str) -> None:
    recorded = np.ones(60, bool)
    recorded[[5, 20, 21, 22]] = False
    ramp = np.arange(60.0)
    filled = Recording("run", 1e-3, ramp, 1e-9 * ramp, 1e-9 * ramp, recorded=recorded)
    write_bag(tmp_path / "run", filled, storage)
    found = read_recording(tmp_path / "run")
    assert np.array_equal(found.present, recorded)
    assert np.array_equal(found.measured[recorded], filled.measured[recorded])
    assert found.setpoint is not None
    # Of a setpoint at a sample that is missing nothing is known.
    before = recorded & np.append(recorded[1:], True)
    assert np.array_equal(found.setpoint[before], 1e-9 * ramp[before])


@pytest.mark.parametrize("storage", STORAGES)
def test_metadata_of_jazzy(tmp_path: Path, storage: str) -> None:
    with BagWriter(tmp_path / "run", storage) as bag:
        bag.add_topic("/setpoint", FLOAT64, QOS)
        bag.add_topic("/silent", FLOAT64)
        for k in range(COUNT):
            bag.write("/setpoint", 5 + k, ONE)
    (file,) = [file for file in (tmp_path / "run").iterdir() if file.name != "metadata.yaml"]
    content = yaml.safe_load((tmp_path / "run" / "metadata.yaml").read_text())
    metadata = content["rosbag2_bagfile_information"]
    assert metadata["version"] == 9
    assert metadata["storage_identifier"] == storage
    assert metadata["relative_file_paths"] == [file.name]
    assert metadata["message_count"] == COUNT
    assert metadata["starting_time"]["nanoseconds_since_epoch"] == 5
    assert metadata["duration"]["nanoseconds"] == COUNT - 1
    setpoint, silent = metadata["topics_with_message_count"]
    assert setpoint["topic_metadata"]["offered_qos_profiles"][0]["durability"] == "transient_local"
    assert setpoint["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
    assert (setpoint["message_count"], silent["message_count"]) == (COUNT, 0)


@pytest.mark.parametrize("storage", STORAGES)
def test_many_flushes_leave_one_good_bag(tmp_path: Path, storage: str) -> None:
    with BagWriter(tmp_path / "run", storage) as bag:
        bag.flush()
        bag.add_topic("/setpoint", FLOAT64)
        bag.flush()
        for k in range(COUNT):
            bag.write("/setpoint", k, ONE)
            bag.flush()
            bag.flush()
    bag.close()
    with AnyReader([tmp_path / "run"]) as reader:
        assert [row[1] for row in reader.messages()] == list(range(COUNT))
    assert len(list((tmp_path / "run").iterdir())) == 2


def test_without_displacement_the_position_is_empty(tmp_path: Path) -> None:
    write_bag(tmp_path / "run", Recording("run", 1e-3, np.arange(10.0), start=-5.0))
    with AnyReader([tmp_path / "run"]) as reader:
        connection, at, content = next(iter(reader.messages()))
        sample = reader.deserialize(content, connection.msgtype)
    assert at == 0
    assert (len(sample.position), len(sample.velocity), len(sample.effort)) == (0, 0, 1)


def test_a_name_that_no_folder_can_have_is_told(tmp_path: Path) -> None:
    with pytest.raises(MicrogripperError, match="File name too long"):
        BagWriter(tmp_path / ("b" * 300))


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    with pytest.raises(MicrogripperError, match="exists already; recordings are not overwritten"):
        BagWriter(tmp_path / "run")
    assert list((tmp_path / "run").iterdir()) == []


@pytest.mark.parametrize("storage", STORAGES)
def test_a_place_that_cannot_be_written(storage: str) -> None:
    with pytest.raises(MicrogripperError, match="/dev/null/run: cannot be written"):
        BagWriter("/dev/null/run", storage)


def test_wrong_requests(tmp_path: Path) -> None:
    with pytest.raises(MicrogripperError, match="unknown storage 'tape'; known are mcap, sqlite3"):
        BagWriter(tmp_path / "run", "tape")
    with BagWriter(tmp_path / "run") as bag:
        with pytest.raises(MicrogripperError, match="ROS 2 Jazzy has no type my_rig/msg/Sample"):
            bag.add_topic("/a", "my_rig/msg/Sample")
        with pytest.raises(MicrogripperError, match="topic /a: bad QoS"):
            bag.add_topic("/a", FLOAT64, "- depth: [")
        bag.add_topic("/a", FLOAT64)
        with pytest.raises(MicrogripperError, match="topic /a is there already"):
            bag.add_topic("/a", FLOAT64)
