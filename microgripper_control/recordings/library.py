"""Bags in forms that only rosbags reads, message by message: rosbag2's own compression."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import islice
from pathlib import Path

from rosbags.interfaces import ConnectionExtRosbag2, MessageDefinitionFormat
from rosbags.rosbag2 import Reader

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.storage import Block, Topic

MESSAGES_AT_ONCE = 4096


class LibraryBag:
    """A whole bag folder; MicrogripperError if rosbags cannot read it."""

    storage = "compressed"
    damage: str | None = None

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        try:
            self._reader = Reader(folder)
            self._reader.open()
        except Exception as error:  # also of the decompressors, which have no common class
            raise self._unreadable(error) from None
        self._topics: dict[int, Topic] = {}
        for connection in self._reader.connections:
            encoding = "cdr"
            if isinstance(connection.ext, ConnectionExtRosbag2):
                encoding = connection.ext.serialization_format
            form, definition = connection.msgdef
            known = definition if form is MessageDefinitionFormat.MSG else ""
            topic = Topic(connection.topic, connection.msgtype, encoding, known)
            self._topics[connection.id] = topic
        self.topics = tuple(dict.fromkeys(self._topics.values()))
        self.counts: dict[str, int] = {}

    def blocks(self, topics: Collection[Topic]) -> Iterator[Block]:
        """The messages of some topics in the order in which they were received."""
        connections = [c for c in self._reader.connections if self._topics[c.id] in topics]
        messages = self._reader.messages(connections)
        while True:
            try:
                rows = list(islice(messages, MESSAGES_AT_ONCE))
            except Exception as error:  # as above
                raise self._unreadable(error) from None
            if not rows:
                return
            for topic in topics:
                mine = [row for row in rows if self._topics[row[0].id] == topic]
                if mine:
                    _, received, contents = zip(*mine, strict=True)
                    yield Block.of(topic, received, contents)

    def close(self) -> None:
        """Let go of the files."""
        self._reader.close()

    def _unreadable(self, error: Exception) -> MicrogripperError:
        reason = " ".join(str(error).split()) or type(error).__name__
        return MicrogripperError(f"{self._folder}: cannot be read: {reason}")
