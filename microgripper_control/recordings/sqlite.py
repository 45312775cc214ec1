"""SQLite3 storage, read as far as it goes.

A file that was closed is read in place. One that was not (its recorder was killed, it was cut off)
is read from a copy, which SQLite may mend; the recording itself is never touched.
"""

from __future__ import annotations

import os
import shutil
import sqlite3
import struct
from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.metadata import counts_in
from microgripper_control.recordings.sqlite_rows import rows_of
from microgripper_control.recordings.storage import Block, Topic

MAGIC = b"SQLite format 3\x00"
WRITE_AHEAD = 18, b"\2\2"  # where the header says that a -wal file belongs to it
SMALLEST_PAGE = 512  # bytes
SIDE_FILES = ("-wal", "-journal")  # beside a file whose writer has not finished


class SqliteFile:
    """One SQLite3 file, whole or not; MicrogripperError if it is no rosbag2.

    `closed` says that its writer is known to have finished.
    """

    storage = "sqlite3"

    def __init__(self, path: Path, *, closed: bool = False) -> None:
        self._path = path
        self._closed = closed
        self._copy: TemporaryDirectory[str] | None = None
        self.damage = self._find_damage()
        self._database = self._connect()
        self._database.text_factory = lambda text: text.decode(errors="replace")
        try:
            self._numbers = self._read_topics()
        except (sqlite3.Error, TypeError):
            self.close()
            raise MicrogripperError(f"{path}: is damaged: its topics cannot be read") from None
        except MicrogripperError:
            self.close()
            raise
        self.topics = tuple(dict.fromkeys(self._numbers.values()))

    def blocks(self, topics: Collection[Topic]) -> Iterator[Block]:
        """The messages of some topics, one topic after the other, in the order of receipt."""
        for number, topic in self._numbers.items():
            if topic in topics:
                yield from rows_of(self._database, number, topic, self._note_damage)

    def _note_damage(self) -> None:
        self.damage = f"{self._path.name} is damaged: what could not be read is missing"

    @cached_property
    def counts(self) -> dict[str, int]:
        """As the file itself says, since version 4 of the format."""
        try:
            rows = self._database.execute("SELECT metadata FROM metadata ORDER BY id").fetchall()
        except sqlite3.Error:
            return {}
        return counts_in(str(rows[-1][0])) if rows else {}

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()
        if self._copy is not None:
            self._copy.cleanup()

    def _find_damage(self) -> str | None:
        with self._path.open("rb") as file:
            header = file.read(100)
        if not header.startswith(MAGIC):
            raise MicrogripperError(f"{self._path}: is not an SQLite file")
        page, pages = struct.unpack_from(">H10xI", header.ljust(100, b"\0"), 16)
        self._page_size = 65536 if page == 1 else page
        size = self._path.stat().st_size
        if self._page_size < SMALLEST_PAGE or size < self._page_size:
            raise MicrogripperError(f"{self._path}: is damaged: its topics cannot be read")
        if size < pages * self._page_size:
            return f"{self._path.name} is cut off: what could not be read is missing"
        if self._side_files():
            return f"{self._path.name} was not closed: what was not yet written is missing"
        where, write_ahead = WRITE_AHEAD
        if header[where:].startswith(write_ahead) and not self._closed:
            return (
                f"{self._path.name} was perhaps not closed: messages in its file "
                f"{self._path.name}-wal, which is not here, would be missing"
            )
        return None

    def _side_files(self) -> list[Path]:
        files = [self._path.with_name(self._path.name + end) for end in SIDE_FILES]
        return [file for file in files if file.is_file() and file.stat().st_size]

    def _connect(self) -> sqlite3.Connection:
        if self.damage is None:
            return sqlite3.connect(f"{self._path.resolve().as_uri()}?immutable=1", uri=True)
        self._copy = self._folder_for_copy()
        for file in (self._path, *self._side_files()):
            shutil.copyfile(file, Path(self._copy.name, file.name))
        copy = Path(self._copy.name, self._path.name)
        # SQLite would take the missing end of a page for zeros, and so for values.
        os.truncate(copy, copy.stat().st_size // self._page_size * self._page_size)
        return sqlite3.connect(copy)

    def _folder_for_copy(self) -> TemporaryDirectory[str]:
        try:
            return TemporaryDirectory()
        except OSError as error:
            where = f" ({error.filename})" if error.filename else ""
            raise MicrogripperError(
                f"{self._path}: was not closed and is read from a copy, which cannot be made: "
                f"{error.strerror}{where}; set TMPDIR to a folder that can be written"
            ) from None

    def _read_topics(self) -> dict[int, Topic]:
        """Topics by their number in the file."""
        # Without the first SQLite refuses a file that is shorter than its header says; the others
        # are its advice for files of unknown origin.
        for setting in ("writable_schema = ON", "trusted_schema = OFF", "cell_size_check = ON"):
            self._database.execute(f"PRAGMA {setting}")
        # Tables alone: a view can be made to go on for ever.
        query = "SELECT name FROM sqlite_master WHERE type = 'table'"
        tables = {name for (name,) in self._database.execute(query)}
        if not {"topics", "messages"} <= tables:
            raise MicrogripperError(f"{self._path}: is an SQLite file but no rosbag2")
        definitions: dict[str, str] = {}
        if "message_definitions" in tables:
            query = "SELECT topic_type, encoded_message_definition FROM message_definitions"
            for kind, definition in self._database.execute(f"{query} WHERE encoding = 'ros2msg'"):
                definitions[str(kind)] = str(definition)
        columns = {row[1] for row in self._database.execute("PRAGMA table_info(topics)")}
        qos = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
        return {
            number: Topic(*map(str, (name, kind, encoding, definitions.get(kind, ""), offered)))
            for number, name, kind, encoding, offered in self._database.execute(
                f"SELECT id, name, type, serialization_format, {qos} FROM topics"
            )
        }
