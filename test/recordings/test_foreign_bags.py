"""Bags of other rigs, and bags that will not do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag_messages import (
    COUNT,
    PERIOD,
    complaint,
    float64,
    joint_state,
    samples,
    write,
    write_of_humble,
)
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from microgripper_control.core.recording import Recording
from microgripper_control.recordings.bag_writer import STORAGES, BagWriter
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.repair import repair_bag


def test_several_setpoints_are_left_to_the_user(tmp_path: Path) -> None:
    sent = [*samples(), float64(0, "/a/setpoint", 1.0), float64(0, "/b/setpoint", 2.0)]
    path = write(tmp_path / "run", sent)
    recording = read_recording(path)
    assert recording.setpoint is None
    assert recording.warnings[0].startswith("several topics match setpoint: /a/setpoint")
    chosen = read_recording(path, Mapping.parse(["setpoint=/b/setpoint"]))
    assert np.array_equal(chosen.setpoint, np.full(COUNT, 2.0))


def test_another_rig_with_scales(tmp_path: Path) -> None:
    """Voltage and displacement on topics without stamps, in other units."""
    sent = []
    for k in range(COUNT):
        sent.append(float64(k * PERIOD, "/rig/gauge", float(k)))
        sent.append(float64(k * PERIOD + 400_000, "/rig/amplifier", 0.1 * k))
    path = write(tmp_path / "run", sent)
    maps = ["voltage=/rig/amplifier*20", "displacement=gauge:data*1e-6"]
    recording = read_recording(path, Mapping.parse(maps))
    # The command that follows sample k - 1 is what the rig holds at sample k.
    assert recording.voltage == pytest.approx(2.0 * np.arange(COUNT - 1.0))
    assert recording.displacement == pytest.approx(1e-6 * np.arange(1.0, COUNT))
    assert recording.start == 1e-3
    assert recording.warnings == (
        "voltage (/rig/amplifier) and displacement (/rig/gauge) come apart: each displacement was "
        "given the newest voltage by time of receipt",
        "dropped before the first voltage: 1 samples",
    )


def test_two_topics_with_stamps_are_aligned_by_them(tmp_path: Path) -> None:
    """The voltage is received late and is stamped a little late, too."""
    sent = []
    for k in range(COUNT):
        stamp = k * PERIOD
        sent.append(joint_state(stamp + 10**6, [1e-6 * k], [], topic="/gauge", stamp=stamp))
        sent.append(
            joint_state(stamp + 9 * 10**6, [], [float(k)], topic="/drive", stamp=stamp + 3000)
        )
    maps = Mapping.parse(["voltage=/drive", "displacement=/gauge"])
    recording = read_recording(write(tmp_path / "run", sent), maps)
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))
    assert recording.warnings[0].endswith("was given the newest voltage by stamp")


def two_topics(path: Path, voltages: list[int], displacements: list[int]) -> Recording:
    """Sample k has k volts and k micrometres; some of each were recorded, at k milliseconds."""
    sent = [float64(k * PERIOD, "/amplifier", float(k)) for k in voltages]
    sent += [float64(k * PERIOD + 5, "/gauge", float(k)) for k in displacements]
    maps = Mapping.parse(["voltage=/amplifier", "displacement=/gauge*1e-6"])
    return read_recording(write(path, sent), maps)


def test_samples_without_a_voltage_in_time_do_not_count(tmp_path: Path) -> None:
    """A voltage is held for three of its periods; then so many messages are lost."""
    recording = two_topics(tmp_path / "run", [*range(100), *range(130, 400)], [*range(400)])
    assert np.array_equal(np.flatnonzero(~recording.present), np.arange(103, 130))
    applied = np.minimum(np.arange(103), 99)
    assert np.array_equal(recording.voltage[:103], applied)
    assert recording.warnings[1] == "no voltage in time for 27 displacements; they were left out"
    assert recording.warnings[2].startswith("missing samples: 27, ")


def test_a_voltage_that_ends_early_ends_the_recording(tmp_path: Path) -> None:
    recording = two_topics(tmp_path / "run", [*range(300)], [*range(3000)])
    assert len(recording) == 303
    assert "no voltage in time for 2697 displacements; they were left out" in recording.warnings


@pytest.mark.parametrize("sent", [[0, 100], [*range(0, 60, 5), *range(100, 400, 150)], [0]])
def test_a_voltage_that_is_sent_when_it_changes_is_held(tmp_path: Path, sent: list[int]) -> None:
    recording = two_topics(tmp_path / "run", sent, [*range(400)])
    assert len(recording) == 400
    assert recording.present.all()
    assert recording.voltage[-1] == sent[-1]


def test_voltages_that_no_displacement_was_read_at_are_told(tmp_path: Path) -> None:
    recording = two_topics(tmp_path / "run", [*range(400)], [*range(0, 400, 10)])
    assert recording.warnings[1:] == (
        "360 of 400 voltages were not used: no displacement was read at them",
    )
    assert len(two_topics(tmp_path / "half", [*range(400)], [*range(0, 400, 2)]).warnings) == 1


def test_voltages_are_taken_in_the_order_of_their_stamps(tmp_path: Path) -> None:
    sent = []
    for k in range(COUNT):
        at = (k ^ 1) * PERIOD  # of two in a row the second is received first
        sent.append(joint_state(k * PERIOD, [1e-6 * k], [], topic="/gauge"))
        sent.append(joint_state(at + 9, [], [float(k)], topic="/drive", stamp=k * PERIOD))
    maps = Mapping.parse(["voltage=/drive", "displacement=/gauge"])
    recording = read_recording(write(tmp_path / "run", sent), maps)
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))


@pytest.mark.parametrize("storage", STORAGES)
def test_a_message_type_of_the_rig_alone(tmp_path: Path, storage: str) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg("float64 drive\nfloat32[] gauges", "my_rig/msg/Sample"))
    with Writer(tmp_path / "run", version=9, storage_plugin=STORAGES[storage]) as writer:
        topic = writer.add_connection("/sample", "my_rig/msg/Sample", typestore=store)
        for k in range(COUNT):
            message = store.types["my_rig/msg/Sample"](float(k), np.array([0, k], np.float32))
            writer.write(topic, k * PERIOD, store.serialize_cdr(message, "my_rig/msg/Sample"))
    maps = ["voltage=sample:drive", "displacement=sample:gauges[1]*1e-6"]
    recording = read_recording(tmp_path / "run", Mapping.parse(maps))
    assert np.array_equal(recording.voltage, np.arange(float(COUNT)))
    assert recording.displacement == pytest.approx(1e-6 * np.arange(COUNT))
    assert "has several numbers; choose one as /sample:FIELD of drive, gauges" in complaint(
        tmp_path / "run", "voltage=sample", maps[1]
    )
    assert "has no number gauge; it has drive, gauges" in complaint(
        tmp_path / "run", "voltage=sample:gauge", maps[1]
    )
    assert "has 2 numbers in gauges; choose one, as gauges[0]" in complaint(
        tmp_path / "run", "voltage=sample:gauges", maps[1]
    )


@pytest.mark.parametrize("storage", STORAGES)
def test_types_of_another_release_of_ros_are_read_and_repaired(
    tmp_path: Path, storage: str
) -> None:
    path = write_of_humble(tmp_path / "run", storage)
    maps = Mapping.parse(["voltage=/amplifier", "displacement=/gauge:range"])
    recording = read_recording(path, maps)
    assert recording.displacement == pytest.approx(1e-3 * np.arange(COUNT), rel=1e-6)
    (path / "metadata.yaml").unlink()
    assert repair_bag(path).kept is not None
    assert np.array_equal(read_recording(path, maps).measured, recording.measured)


def test_a_joint_state_that_has_no_names_is_told(tmp_path: Path) -> None:
    """A type of that name may have any definition."""
    kind = "sensor_msgs/msg/JointState"
    with BagWriter(tmp_path / "run") as bag:
        bag.add_topic("/joint_states", kind, definition="float64 volts")
        for k in range(COUNT):
            bag.write("/joint_states", k, b"\0\1\0\0" + np.float64(k).tobytes())
    assert "has no number effort" in complaint(tmp_path / "run")


def test_a_recording_of_the_voltage_alone(tmp_path: Path) -> None:
    sent = [joint_state(k * PERIOD, [], [float(k)]) for k in range(COUNT)]
    path = write(tmp_path / "run", sent)
    assert read_recording(path, needs_displacement=False).displacement is None
    assert "in message 0 has 0 numbers in position" in complaint(path)


def test_the_topics_it_has_are_listed(tmp_path: Path) -> None:
    path = write(tmp_path / "run", [float64(0, "/b/joint_states", 1.0), float64(0, "/a", 1.0)])
    assert complaint(path) == (
        f"{path}: no topic joint_states (sensor_msgs/msg/JointState); it has "
        "/a (std_msgs/msg/Float64), /b/joint_states (std_msgs/msg/Float64); "
        "choose one with --map voltage=TOPIC[:FIELD]"
    )
    assert "no topic /c; it has /a" in complaint(path, "voltage=/c")


def test_several_topics_that_match(tmp_path: Path) -> None:
    path = write(
        tmp_path / "run", [*samples(topic="/l/joint_states"), *samples(topic="/r/joint_states")]
    )
    assert (
        "several topics match joint_states: /l/joint_states (sensor_msgs/msg/JointState), "
        "/r/joint_states (sensor_msgs/msg/JointState); choose one with --map voltage=TOPIC"
    ) in complaint(path)
    recording = read_recording(
        path, Mapping.parse(["voltage=/l/joint_states", "displacement=/l/joint_states"])
    )
    assert len(recording) == COUNT


@pytest.mark.parametrize(
    ("values", "quantity"), [(([np.nan], [1.0]), "displacement"), (([0.0], [-np.inf]), "voltage")]
)
def test_samples_that_are_not_finite(
    tmp_path: Path, values: tuple[list[float], list[float]], quantity: str
) -> None:
    sent = samples()
    sent[17] = joint_state(17 * PERIOD, *values)
    assert f"{quantity} is " in complaint(write(tmp_path / "run", sent))
    assert "at sample 17" in complaint(tmp_path / "run")


def test_time_that_runs_backwards(tmp_path: Path) -> None:
    """The plant was restarted while the recorder ran on."""
    sent = samples() + [
        joint_state((COUNT + k) * PERIOD, [0.0], [0.0], stamp=k * PERIOD) for k in range(COUNT)
    ]
    assert "time runs backwards at sample 40, from 0.039 s to 0 s" in complaint(
        write(tmp_path / "run", sent)
    )


def test_lost_messages_are_told(tmp_path: Path) -> None:
    sent = samples()
    del sent[20:23]
    recording = read_recording(write(tmp_path / "run", sent))
    assert len(recording) == COUNT
    assert recording.warnings[0].startswith("missing samples: 3, the longest gap is 0.004 s")


def test_too_few_samples(tmp_path: Path) -> None:
    assert "3 samples; at least 10" in complaint(write(tmp_path / "run", samples(3)))
    path = write(tmp_path / "none", [])
    assert "it has no topics" in complaint(path)


def test_time_cannot_be_mapped(tmp_path: Path) -> None:
    path = write(tmp_path / "run", samples())
    assert "--map time= is for CSV" in complaint(path, "time=/joint_states")
