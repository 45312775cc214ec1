"""Recordings out: rosbag2 folders, as the messages arrive or all at once, and CSV."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Literal

import numpy as np
from rosbags.interfaces import Connection
from rosbags.rosbag2 import ReaderError, StoragePlugin, Writer, WriterError
from rosbags.rosbag2.metadata import parse_qos
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Writer
from rosbags.typesys import Stores, TypesysError, get_typestore

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import written_whole
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.recordings.bag_recording import FLOAT64, JOINT, JOINT_STATE

STORAGES = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
VERSION: Literal[9] = 9  # of the bag's metadata: ROS 2 Jazzy's
JOINT_STATES = "/microgripper/joint_states"
SETPOINT = "/microgripper/setpoint"


class BagWriter:
    """Writes a new rosbag2 folder; a context manager, used from one thread.

    What was written before the last `flush` survives the death of the process: an MCAP chunk is
    closed, an SQLite transaction committed. Without it MCAP keeps up to a mebibyte in memory, and
    SQLite commits at the end alone. Raises MicrogripperError where the folder exists already or
    nothing more can be written.
    """

    def __init__(self, path: str | Path, storage: str = "mcap") -> None:
        self.path = Path(path)
        if storage not in STORAGES:
            known = ", ".join(STORAGES)
            raise MicrogripperError(f"{path}: unknown storage {storage!r}; known are {known}")
        if self.path.exists():
            raise MicrogripperError(f"{path}: exists already; recordings are not overwritten")
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._topics: dict[str, Connection] = {}
        self._writer = Writer(self.path, version=VERSION, storage_plugin=STORAGES[storage])
        with self._writing():
            self._writer.open()
            if isinstance(self._writer.storage, Sqlite3Writer):
                # Commits go to a file beside it, without waiting for the disk.
                self._writer.storage.conn.execute("PRAGMA journal_mode = WAL")
                self._writer.storage.conn.execute("PRAGMA synchronous = NORMAL")

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def add_topic(self, name: str, kind: str, qos: str = "") -> None:
        """Announce a topic, its type (`std_msgs/msg/Float64`) and its offered QoS, as rosbag2 YAML.

        The type has to be one of those that ROS 2 Jazzy comes with.
        """
        if name in self._topics:
            raise MicrogripperError(f"{self.path}: topic {name} is there already")
        try:
            profiles = parse_qos(qos)
        except (ReaderError, KeyError, TypeError):
            raise MicrogripperError(f"{self.path}: topic {name}: bad QoS {qos!r:.60}") from None
        try:
            with self._writing():
                self._topics[name] = self._writer.add_connection(
                    name, kind, typestore=self._types, offered_qos_profiles=profiles
                )
        except (TypesysError, KeyError):
            raise MicrogripperError(
                f"{self.path}: topic {name}: ROS 2 Jazzy has no type {kind}; leave the topic out"
            ) from None

    def write(self, topic: str, stamp: int, message: bytes) -> None:
        """Write a serialized message (CDR) received at `stamp`, ns since 1970."""
        with self._writing():
            self._writer.write(self._topics[topic], stamp, message)

    def flush(self) -> None:
        """Hand everything written so far to the operating system."""
        storage = self._writer.storage
        with self._writing():
            if isinstance(storage, McapWriter):
                if storage.chunk.msgs:
                    storage.close_chunk()
                storage.bio.flush()
            elif isinstance(storage, Sqlite3Writer):
                storage.conn.commit()

    def close(self) -> None:
        """Complete the bag; a bag that is closed already stays as it is."""
        if self._writer.storage is None:
            return
        try:
            self.flush()
            with self._writing():
                if isinstance(self._writer.storage, Sqlite3Writer):
                    # One file alone, which can also be read where nothing can be written.
                    self._writer.storage.conn.execute("PRAGMA journal_mode = DELETE")
                self._writer.close()
        except MicrogripperError:
            with suppress(OSError, sqlite3.Error):
                self._writer.abort()
            raise

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except (OSError, sqlite3.Error, WriterError) as error:
            reason = getattr(error, "strerror", None) or error
            raise MicrogripperError(f"{self.path}: cannot be written: {reason}") from None


def write_csv(path: str | Path, recording: Recording) -> None:
    """Write `time_s,voltage_V` and what else was recorded; every digit is kept.

    Samples that were filled in are left out: whoever reads the file fills them in and knows it.
    """
    columns = {"time_s": recording.time, "voltage_V": recording.voltage}
    if recording.displacement is not None:
        columns["displacement_m"] = recording.displacement
    if recording.setpoint is not None:
        columns["setpoint_m"] = recording.setpoint
    with written_whole(path) as file:
        file.write(",".join(columns) + "\n")
        read = recording.present
        for row in zip(*(column[read].tolist() for column in columns.values()), strict=True):
            file.write(",".join(map(repr, row)) + "\n")


def write_bag(path: str | Path, recording: Recording, storage: str = "mcap") -> None:
    """Write `joint_states` and, if there is one, `setpoint`, as the plant and `reference` would.

    Each message is received at its stamp; a setpoint follows the sample that it answers by a
    quarter of the sample period. A recording that starts before 1970 is moved to begin there.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    stamp, header = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Header"]
    joint_state, float64 = store.types[JOINT_STATE], store.types[FLOAT64]
    start, period = round(1e9 * max(recording.start, 0.0)), 1e9 * recording.sample_period  # ns
    ticks = start + np.rint(period * np.arange(len(recording))).astype(np.int64)
    positions = recording.displacement
    velocities = (
        None if positions is None else np.diff(positions, prepend=positions[0]) * 1e9 / period
    )
    with BagWriter(path, storage) as bag:
        bag.add_topic(JOINT_STATES, JOINT_STATE)
        if recording.setpoint is not None:
            bag.add_topic(SETPOINT, FLOAT64)
        for k, tick in enumerate(ticks.tolist()):
            message = joint_state(
                header=header(stamp=stamp(*divmod(tick, 10**9)), frame_id=""),
                name=[JOINT],
                position=_part(positions, k),
                velocity=_part(velocities, k),
                effort=_part(recording.voltage, k),
            )
            bag.write(JOINT_STATES, tick, bytes(store.serialize_cdr(message, JOINT_STATE)))
            if recording.setpoint is not None and np.isfinite(recording.setpoint[k]):
                wanted = float64(data=float(recording.setpoint[k]))
                after = tick + int(period / 4)
                bag.write(SETPOINT, after, bytes(store.serialize_cdr(wanted, FLOAT64)))


def _part(samples: Array | None, index: int) -> Array:
    """One sample as an array; empty where nothing was recorded."""
    return np.empty(0) if samples is None else samples[index : index + 1]
