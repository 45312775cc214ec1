from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bag_messages import (
    COUNT,
    FLOAT64,
    JOINT_STATE,
    PERIOD,
    STORE,
    complaint,
    float64,
    joint_state,
    samples,
    write,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.bag_writer import STORAGES, BagWriter
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.write import write_bag


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_what_was_written_is_read(tmp_path: Path, storage: str, start: float) -> None:
    rng = np.random.default_rng(3)
    voltage, displacement, setpoint = rng.standard_normal((3, 500))
    setpoint[:4] = np.nan
    recording = Recording("run", 1 / 750, voltage, displacement, setpoint, start)
    write_bag(tmp_path / "run", recording, storage)
    (file,) = [file for file in (tmp_path / "run").iterdir() if file.name != "metadata.yaml"]
    for path in (tmp_path / "run", file):
        found = read_recording(path)
        assert found.name == str(path)
        assert found.sample_period == pytest.approx(1 / 750, rel=1e-9)
        assert found.start == start
        assert np.array_equal(found.voltage, voltage)
        assert np.array_equal(found.displacement, displacement)
        assert np.array_equal(found.setpoint, setpoint, equal_nan=True)
        assert found.warnings == ()


@pytest.mark.parametrize("storage", STORAGES)
def test_blocks_are_put_together(
    tmp_path: Path, storage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Far more messages than are read at a time."""
    monkeypatch.setattr("microgripper_control.recordings.mcap_records.RECORDS_AT_ONCE", 7)
    monkeypatch.setattr("microgripper_control.recordings.sqlite_rows.ROWS_AT_ONCE", 7)
    recording = Recording("run", 1e-3, np.arange(100.0), np.arange(100.0), np.arange(100.0))
    write_bag(tmp_path / "run", recording, storage)
    found = read_recording(tmp_path / "run")
    assert np.array_equal(found.voltage, recording.voltage)
    assert np.array_equal(found.setpoint, recording.setpoint)


@pytest.mark.parametrize(
    ("storage", "compression"),
    [
        ("mcap", CompressionMode.FILE),
        ("mcap", CompressionMode.MESSAGE),
        ("mcap", CompressionMode.STORAGE),
        ("sqlite3", CompressionMode.FILE),
        ("sqlite3", CompressionMode.MESSAGE),
    ],
)
def test_compressed_bags(tmp_path: Path, storage: str, compression: CompressionMode) -> None:
    path = write(tmp_path / "run", samples(), storage, compression)
    assert np.array_equal(read_recording(path).voltage, np.arange(float(COUNT)))
    (file,) = [file for file in path.iterdir() if file.name != "metadata.yaml"]
    file.write_bytes(file.read_bytes()[:-3000])
    if compression is not CompressionMode.STORAGE:  # which is read like a plain file
        assert "cannot be read: " in complaint(path)


@pytest.mark.parametrize("compression", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_a_compressed_bag_s_own_type(tmp_path: Path, compression: CompressionMode) -> None:
    kind, store = "my_rig/msg/Sample", get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg("float64 drive\nfloat64 gauge", kind))
    writer = Writer(tmp_path / "run", version=9, storage_plugin=STORAGES["mcap"])
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        topic = writer.add_connection("/sample", kind, typestore=store)
        for k in range(COUNT):
            message = store.types[kind](float(k), 1e-6 * k)
            writer.write(topic, k * PERIOD, store.serialize_cdr(message, kind))
    maps = Mapping.parse(["voltage=sample:drive", "displacement=sample:gauge"])
    recording = read_recording(tmp_path / "run", maps)
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))


@pytest.mark.parametrize(
    "topic", ["/joint_states", "/microgripper/joint_states", "/a/b/joint_states"]
)
def test_any_namespace(tmp_path: Path, topic: str) -> None:
    path = write(tmp_path / "run", [*samples(topic=topic), *samples(topic="/other_joint_states")])
    recording = read_recording(path)
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))
    assert recording.setpoint is None


def test_time_is_the_stamp_not_the_receipt(tmp_path: Path) -> None:
    """In lockstep a second of the rig passes in less than one."""
    sent = [
        joint_state(k * PERIOD // 3 + k % 2 * 1000, [0.0], [float(k)], stamp=10**9 + k * PERIOD)
        for k in range(COUNT)
    ]
    recording = read_recording(write(tmp_path / "run", sent))
    assert (recording.sample_period, recording.start) == (1e-3, 1.0)
    assert recording.warnings == ()


def test_without_stamps_the_receipt_will_do(tmp_path: Path) -> None:
    sent = [joint_state(k * PERIOD, [0.0], [float(k)], stamp=0) for k in range(COUNT)]
    recording = read_recording(write(tmp_path / "run", sent))
    assert recording.sample_period == 1e-3
    assert recording.warnings == (
        "/joint_states carries no stamps: the times of receipt were used",
    )


def test_the_finger_is_found_by_name(tmp_path: Path) -> None:
    sent = [
        joint_state(k * PERIOD, [9.0, 1e-6 * k], [9.0, float(k)], names=["wrist", "finger"])
        for k in range(COUNT)
    ]
    path = write(tmp_path / "run", sent)
    assert np.array_equal(read_recording(path).voltage, np.arange(float(COUNT)))
    other = read_recording(path, Mapping.parse(["voltage=joint_states:effort[0]"]))
    assert np.array_equal(other.voltage, np.full(COUNT, 9.0))
    sent = [joint_state(k * PERIOD, [0.0, 0.0], [0.0, 0.0], names=["a", "b"]) for k in range(COUNT)]
    assert "has the joints a, b, no 'finger'; choose one, as effort[0]" in complaint(
        write(tmp_path / "no finger", sent)
    )


def test_the_only_joint_may_have_any_name(tmp_path: Path) -> None:
    sent = [joint_state(k * PERIOD, [0.0], [float(k)], names=["jaw"]) for k in range(COUNT)]
    assert np.array_equal(
        read_recording(write(tmp_path / "run", sent)).voltage, np.arange(float(COUNT))
    )


def test_a_setpoint_belongs_to_the_sample_before_it(tmp_path: Path) -> None:
    """The newest before the next sample answers; whether it came at once or late."""
    sent = samples()
    sent += [
        float64(k * PERIOD + 300_000, "/setpoint", float(k)) for k in range(2, COUNT) if k != 5
    ]
    sent.append(float64(4 * PERIOD + 999_999, "/setpoint", 4.5))
    setpoint = read_recording(write(tmp_path / "run", sent)).setpoint
    expected = np.arange(float(COUNT))
    expected[:2] = np.nan
    expected[4:6] = 4.5
    assert np.array_equal(setpoint, expected, equal_nan=True)


def test_a_setpoint_in_the_last_moment(tmp_path: Path) -> None:
    """Received at the very time of the next sample, it is an answer to that one."""
    sent = [*samples(), *(float64((k + 1) * PERIOD, "/setpoint", float(k)) for k in range(COUNT))]
    setpoint = read_recording(write(tmp_path / "run", sent)).setpoint
    assert setpoint is not None
    assert np.isnan(setpoint[0])
    assert np.array_equal(setpoint[1:-1], np.arange(COUNT - 2.0))
    assert setpoint[-1] == COUNT - 1.0


def test_a_setpoint_that_nobody_sent(tmp_path: Path) -> None:
    """A recorder announces the topic whether or not there is a `reference`."""
    with BagWriter(tmp_path / "run") as bag:
        bag.add_topic("/setpoint", FLOAT64)
        bag.add_topic("/joint_states", JOINT_STATE)
        for one in samples():
            bag.write(one.topic, one.at, bytes(STORE.serialize_cdr(one.message, one.kind)))
    recording = read_recording(tmp_path / "run")
    assert recording.setpoint is None
    assert recording.warnings == ()
    assert "/setpoint (std_msgs/msg/Float64) holds no messages" in complaint(
        tmp_path / "run", "setpoint=/setpoint"
    )


def test_a_split_bag_is_read_in_its_order(tmp_path: Path) -> None:
    whole = samples()
    for part in range(4):
        write(tmp_path / f"part_{part}", whole[10 * part : 10 * part + 10])
    bag = tmp_path / "run"
    bag.mkdir()
    for part in range(4):
        (tmp_path / f"part_{part}" / f"part_{part}.mcap").rename(bag / f"run_{part + 8}.mcap")
    recording = read_recording(bag)
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))
    assert recording.warnings == (
        "metadata.yaml is missing or damaged; the storage files were read",
    )


def test_a_bad_part_of_a_split_bag_is_told(tmp_path: Path) -> None:
    bag = write(tmp_path / "run", samples())
    (bag / "metadata.yaml").unlink()
    (bag / "run_1.mcap").write_bytes(b"")
    recording = read_recording(bag)
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))
    assert f"{bag / 'run_1.mcap'}: is empty" in recording.warnings
    (bag / "run.mcap").write_bytes(b"")
    assert "run.mcap: is empty" in complaint(bag)


def test_a_part_of_a_split_bag_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    bag = write(tmp_path / "run", samples())
    (bag / "metadata.yaml").unlink()
    (bag / "run_1.mcap").mkdir()
    recording = read_recording(bag)
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))
    assert f"{bag / 'run_1.mcap'}: cannot be read: Is a directory" in recording.warnings


@pytest.mark.parametrize(("storage", "end"), [("mcap", "mcap"), ("sqlite3", "db3")])
def test_a_compressed_file_without_metadata_is_to_be_unpacked(
    tmp_path: Path, storage: str, end: str
) -> None:
    bag = write(tmp_path / "run", samples(), storage, CompressionMode.FILE)
    (bag / "metadata.yaml").unlink()
    packed = bag / f"run.{end}.zstd"
    expected = f"{packed}: is compressed; unpack it with zstd -d run.{end}.zstd -o run.{end}"
    assert complaint(packed) == expected
    with pytest.raises(MicrogripperError) as caught:
        read_recording(bag)
    assert expected in str(caught.value)
    part = write(tmp_path / "part", samples(), storage) / f"part.{end}"
    part.rename(bag / f"run_1.{end}")
    assert expected in read_recording(bag).warnings
    (bag / f"run_1.{end}").rename(bag / f"run.{end}")
    assert len(read_recording(bag).warnings) == 1, "it was unpacked"


def test_messages_in_order_of_receipt(tmp_path: Path) -> None:
    sent = [*samples(), *(float64(k * PERIOD + 5, "/setpoint", 1.0) for k in range(COUNT))]
    for storage in STORAGES:
        path = write(tmp_path / storage, sent, storage)
        with Bag(path) as bag:
            assert [str(topic) for topic in bag.topics] == [
                f"/joint_states ({JOINT_STATE})",
                f"/setpoint ({FLOAT64})",
            ]
            found = list(bag.messages(bag.topics))
            assert [row[1] for row in found] == sorted(one.at for one in sent)
            assert [row[0].name for row in found[:4]] == ["/joint_states", "/setpoint"] * 2
            topic, at, content = found[-1]
            assert (at, topic.type) == ((COUNT - 1) * PERIOD + 5, FLOAT64)
            assert STORE.deserialize_cdr(content, FLOAT64) == STORE.types[FLOAT64](1.0)
            assert len(list(bag.messages(bag.topics[1:]))) == COUNT


@pytest.mark.parametrize("storage", STORAGES)
def test_messages_in_order_of_receipt_chunk_by_chunk(tmp_path: Path, storage: str) -> None:
    """Some topics are not in all chunks; of a bag by rosbag2 a chunk is half a second."""
    topics = ("/a", "/b", "/c")
    rng, sent = np.random.default_rng(2), []
    with BagWriter(tmp_path / "run", storage) as bag:
        for topic in topics:
            bag.add_topic(topic, FLOAT64)
        for at in range(300):
            sent.append((str(rng.choice(topics[: 1 + at // 100])), at))
            message = STORE.serialize_cdr(STORE.types[FLOAT64](float(at)), FLOAT64)
            bag.write(*sent[-1], bytes(message))
            if at % 7 == 0:
                bag.flush()
    with Bag(tmp_path / "run") as bag:
        assert [(topic.name, at) for topic, at, _ in bag.messages(bag.topics)] == sent
        assert list(bag.messages([])) == []


@pytest.mark.parametrize("compression", [CompressionMode.NONE, CompressionMode.FILE])
def test_the_messages_of_many_topics_are_read_in_one_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: CompressionMode
) -> None:
    sent = [float64(k * PERIOD + n, f"/topic_{n}", 1.0) for n in range(9) for k in range(COUNT)]
    passes = []
    with Bag(write(tmp_path / "run", sent, compression=compression)) as bag:
        blocks = bag.blocks
        monkeypatch.setattr(bag, "blocks", lambda some: passes.append(some) or blocks(some))
        found = [at for _, at, _ in bag.messages(bag.topics)]
    assert found == sorted(one.at for one in sent)
    assert len(passes) == 1


@pytest.mark.parametrize(
    ("names", "position", "effort"),
    [(["stage"], [5e-3], [7.0]), (["stage"], [5e-3], []), (["s", "t"], [1.0, 2.0], [3.0, 4.0])],
)
def test_a_topic_that_drivers_share(
    tmp_path: Path, names: list[str], position: list[float], effort: list[float]
) -> None:
    """Each has joints of its own; those of the finger are read, though they come second."""
    other = [joint_state(k * PERIOD, position, effort, names=names) for k in range(COUNT)]
    own = [replace(one, at=one.at + PERIOD // 2) for one in samples()]
    recording = read_recording(write(tmp_path / "run", [*other, *own]))
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))
    assert np.allclose(recording.measured, 1e-6 * np.arange(COUNT), atol=1e-18)
    assert recording.warnings == (f"/joint_states: {COUNT} messages are of other joints",)


def test_drivers_that_share_a_topic_without_a_finger(tmp_path: Path) -> None:
    other = [joint_state(k * PERIOD, [5e-3], [7.0], names=["stage"]) for k in range(COUNT)]
    wrist = [joint_state(k * PERIOD + 9, [5e-3], [7.0], names=["wrist"]) for k in range(COUNT)]
    assert "has messages of stage, wrist; call the one to be read 'finger'" in complaint(
        write(tmp_path / "others", [*other, *wrist])
    )


def test_an_index_is_refused_where_drivers_share_a_topic(tmp_path: Path) -> None:
    other = [joint_state(k * PERIOD + 9, [5e-3], [7.0], names=["stage"]) for k in range(COUNT)]
    path = write(tmp_path / "run", [*samples(), *other])
    maps = ["voltage=joint_states:effort[0]", "displacement=joint_states:position[0]"]
    assert complaint(path, *maps) == (
        f"{path}: topic /joint_states has messages of finger, stage; call the one to be read "
        "'finger' and map it without an index, or record it on a topic of its own"
    )
    mixed = read_recording(path, Mapping.parse(maps[:1]))  # the displacement tells which are read
    assert np.array_equal(mixed.voltage, np.arange(float(COUNT)))


@pytest.mark.parametrize("mapped", [["voltage=joint_states:effort[0]"], []])
def test_joints_in_another_order_are_found_by_name_alone(tmp_path: Path, mapped: list[str]) -> None:
    """The driver was started anew with its joints the other way round."""
    sent = []
    for k in range(COUNT):
        names, values = ["finger", "wrist"], [float(k), 9.0]
        way = slice(None, None, 1 if k < COUNT // 2 else -1)
        sent.append(joint_state(k * PERIOD, values[way], values[way], names=names[way]))
    path = write(tmp_path / "run", sent)
    if mapped:
        assert "has messages of finger+wrist, wrist+finger; " in complaint(path, *mapped)
    else:
        assert np.array_equal(read_recording(path).voltage, np.arange(float(COUNT)))


def test_a_driver_without_names_is_not_mixed_with_another(tmp_path: Path) -> None:
    nameless = [joint_state(k * PERIOD, [1e-6], [float(k)], names=[]) for k in range(COUNT)]
    other = [joint_state(k * PERIOD + 9, [5e-3], [7.0], names=["stage"]) for k in range(COUNT)]
    alone = read_recording(write(tmp_path / "alone", nameless))
    assert np.array_equal(alone.voltage, np.arange(float(COUNT)))
    mixed = write(tmp_path / "mixed", [*nameless, *other])
    assert "has messages of no joint, stage; call the one" in complaint(mixed)


def test_a_finger_that_reads_nothing_is_no_other_joint(tmp_path: Path) -> None:
    sent = samples()
    sent[7] = joint_state(7 * PERIOD, [np.nan], [np.nan])
    assert "sample 7" in complaint(write(tmp_path / "run", sent))
