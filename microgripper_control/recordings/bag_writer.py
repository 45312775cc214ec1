"""A rosbag2 as it is written, message by message."""

from __future__ import annotations

import sqlite3
import struct
from binascii import crc32
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Literal

from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Writer
from rosbags.typesys import Stores, TypesysError, get_typestore
from rosbags.typesys.store import Typestore

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.folder_lock import FolderLock
from microgripper_control.recordings.message_types import types_with
from microgripper_control.recordings.offered_qos import profiles_in

STORAGES = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
VERSION: Literal[9] = 9  # of the bag's metadata: ROS 2 Jazzy's
LATEST = 2**63 - 1  # ns since 1970
CHECKSUM_AT = 9 + 24  # bytes into the record of an MCAP chunk


class _CheckedMcapWriter(McapWriter):
    """Gives each chunk the checksum of its content, by which a byte that changed is noticed."""

    def close_chunk(self) -> None:
        start, checksum = self.bio.tell(), crc32(self.chunk.bio.getbuffer())
        super().close_chunk()
        end = self.bio.tell()
        self.bio.seek(start + CHECKSUM_AT)
        self.bio.write(struct.pack("<I", checksum))
        self.bio.seek(end)


PLUGINS = {**Writer.STORAGE_PLUGINS, StoragePlugin.MCAP: _CheckedMcapWriter}


class BagWriter:
    """Writes a new rosbag2 folder; a context manager, used from one thread.

    What was written before the last `flush` survives the death of the process: an MCAP chunk is
    closed, an SQLite transaction committed. Without it MCAP keeps up to a mebibyte in memory, and
    SQLite commits at the end alone. While it is open the folder is locked against repair. Raises
    MicrogripperError where the folder exists already or nothing more can be written.
    """

    def __init__(self, path: str | Path, storage: str = "mcap") -> None:
        self.path = Path(path)
        if storage not in STORAGES:
            known = ", ".join(STORAGES)
            raise MicrogripperError(f"{path}: unknown storage {storage!r}; known are {known}")
        self.broken = False  # nothing more can be written
        self._types = get_typestore(Stores.ROS2_JAZZY)
        self._topics: dict[str, Connection] = {}
        with self._writing():
            if self.path.exists():
                raise MicrogripperError(f"{path}: exists already; recordings are not overwritten")
            self._writer = Writer(self.path, version=VERSION, storage_plugin=STORAGES[storage])
            self._writer.STORAGE_PLUGINS = PLUGINS
            self._writer.open()
            self._lock = FolderLock(self.path)
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

    def add_topic(
        self, name: str, kind: str, qos: str = "", *, encoding: str = "cdr", definition: str = ""
    ) -> None:
        """Announce a topic, its type (`std_msgs/msg/Float64`) and its offered QoS, as rosbag2 YAML.

        A type that does not come with ROS 2 Jazzy, or not as it is meant, needs its `definition`,
        in .msg form.
        """
        if name in self._topics:
            raise MicrogripperError(f"{self.path}: topic {name} is there already")
        try:
            profiles = profiles_in(qos)
        except MicrogripperError as error:
            raise MicrogripperError(f"{self.path}: topic {name}: {error}") from None
        try:
            with self._writing():
                self._topics[name] = self._writer.add_connection(
                    name,
                    kind,
                    typestore=self._types_with(kind, definition),
                    serialization_format=encoding,
                    offered_qos_profiles=profiles,
                )
        except (TypesysError, ValueError, LookupError, RecursionError):
            raise MicrogripperError(
                f"{self.path}: topic {name}: ROS 2 Jazzy has no type {kind}; leave the topic out"
            ) from None

    def _types_with(self, kind: str, definition: str) -> Typestore:
        if not definition:
            return self._types
        types = get_typestore(Stores.ROS2_JAZZY)
        types.fielddefs.update(types_with(kind, definition))  # `register` would keep Jazzy's
        return types

    def write(self, topic: str, stamp: int, message: bytes) -> None:
        """Write a serialized message (CDR) received at `stamp`, ns since 1970.

        A time before, or one that 63 bits do not hold, is as near as the formats have it.
        """
        with self._writing():
            self._writer.write(self._topics[topic], min(max(stamp, 0), LATEST), message)

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
        finally:
            self._lock.close()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except (OSError, sqlite3.Error, WriterError) as error:
            self.broken = True
            reason = getattr(error, "strerror", None) or error
            raise MicrogripperError(f"{self.path}: cannot be written: {reason}") from None
