"""Bags made with the library's own writer, apart from which the package's writer is tested."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer
from rosbags.typesys import Stores, get_typestore

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.bag_writer import STORAGES
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording

STORE = get_typestore(Stores.ROS2_JAZZY)
JOINT_STATE = "sensor_msgs/msg/JointState"
FLOAT64 = "std_msgs/msg/Float64"
COUNT = 40
PERIOD = 10**6  # ns
# What a publisher offers, as metadata.yaml keeps it; `{}` is the reliability.
QUALITY = """\
- history: keep_last
  depth: 10
  reliability: {}
  durability: transient_local
  deadline: {{sec: 0, nsec: 0}}
  lifespan: {{sec: 0, nsec: 0}}
  liveliness: automatic
  liveliness_lease_duration: {{sec: 0, nsec: 0}}
  avoid_ros_namespace_conventions: false
"""


@dataclass(frozen=True)
class Sent:
    """A message on its way into a bag; `at` is its time of receipt, ns."""

    at: int
    topic: str
    kind: str
    message: object


def float64(at: int, topic: str, value: float) -> Sent:
    return Sent(at, topic, FLOAT64, STORE.types[FLOAT64](value))


def joint_state(
    at: int,
    position: Sequence[float],
    effort: Sequence[float],
    *,
    topic: str = "/joint_states",
    names: Sequence[str] = ("finger",),
    stamp: int | None = None,
) -> Sent:
    types = STORE.types
    seconds, nanoseconds = divmod(at if stamp is None else stamp, 10**9)
    header = types["std_msgs/msg/Header"](
        types["builtin_interfaces/msg/Time"](seconds, nanoseconds), "rig"
    )
    arrays = np.array(position), np.empty(0), np.array(effort)
    return Sent(at, topic, JOINT_STATE, types[JOINT_STATE](header, list(names), *arrays))


def samples(count: int = COUNT, topic: str = "/joint_states") -> list[Sent]:
    """Sample k: k volts, k micrometres, at k milliseconds."""
    return [joint_state(k * PERIOD, [1e-6 * k], [float(k)], topic=topic) for k in range(count)]


def write(
    path: Path,
    sent: list[Sent],
    storage: str = "mcap",
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """Write a new bag of the messages, in the order of their receipt."""
    writer = Writer(path, version=9, storage_plugin=STORAGES[storage])
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        topics = {}
        for one in sorted(sent, key=lambda one: one.at):
            if one.topic not in topics:
                topics[one.topic] = writer.add_connection(one.topic, one.kind, typestore=STORE)
            writer.write(topics[one.topic], one.at, STORE.serialize_cdr(one.message, one.kind))
    return path


def write_of_humble(path: Path, storage: str) -> Path:
    """A bag of ROS 2 Humble, whose Range has no `variance`: k volts and k millimetres."""
    store, kind = get_typestore(Stores.ROS2_HUMBLE), "sensor_msgs/msg/Range"
    header = store.types["std_msgs/msg/Header"]
    time = store.types["builtin_interfaces/msg/Time"]
    with Writer(path, version=8, storage_plugin=STORAGES[storage]) as writer:
        gauge = writer.add_connection("/gauge", kind, typestore=store)
        amplifier = writer.add_connection("/amplifier", FLOAT64, typestore=store)
        for k in range(COUNT):
            volts = store.types[FLOAT64](float(k))
            stamped = header(time(0, k * PERIOD), "rig")
            reading = store.types[kind](stamped, 1, 0.1, 0.0, 1.0, 1e-3 * k)
            writer.write(amplifier, k * PERIOD, store.serialize_cdr(volts, FLOAT64))
            writer.write(gauge, k * PERIOD, store.serialize_cdr(reading, kind))
    return path


def complaint(path: Path, *maps: str) -> str:
    with pytest.raises(MicrogripperError) as caught:
        read_recording(path, Mapping.parse(maps))
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(path))
    return str(caught.value)
