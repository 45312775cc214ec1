"""MCAP storage, read in bulk and as far as it goes.

rosbags reads MCAP message by message and refuses a file without its end, which is what a recorder
that was killed leaves behind. Here the records are found by a compiled loop, the messages stay
where they are in the file, and what is damaged is passed over and told.
"""

from __future__ import annotations

import struct
from binascii import crc32
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

import numpy as np
from rosbags.rosbag2.storage_mcap import decompress

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.mcap_records import (
    CHANNEL,
    CHUNK,
    CHUNK_HEAD,
    FOOTER,
    MESSAGE,
    RECORD_HEAD,
    SCHEMA,
    STATISTICS,
    Records,
    is_whole_chunk,
    pairs_of_texts,
    texts,
)
from microgripper_control.recordings.storage import Block, Bytes, Topic, bytes_from

MAGIC = b"\x89MCAP0\r\n"
MESSAGE_HEAD = 22  # bytes: channel, sequence, time logged, time published
FOOTER_SIZE = RECORD_HEAD + 20
STATISTICS_HEAD = struct.Struct("<QHIIIIQQI")  # counts, times, length of the counts by channel
UNKNOWN = "unknown type", ""  # of a topic whose schema is not there
QOS = "offered_qos_profiles"
SEARCHED_AT_ONCE = 2**24  # bytes


class McapFile:
    """One MCAP file, whole or not; MicrogripperError if it is none."""

    storage = "mcap"

    def __init__(self, path: Path) -> None:
        self._path = path
        self._data: Bytes = np.asarray(np.memmap(path, np.uint8, mode="r"))
        if self._data[: len(MAGIC)].tobytes() != MAGIC:
            raise MicrogripperError(f"{path}: is not an MCAP file")
        self._damaged: list[int] = []  # bytes at which something could not be read
        self._definitions: dict[int, tuple[str, str]] = {}  # schema -> type, its definition
        self._channels: dict[int, Topic] = {}
        self.counts: dict[str, int] = {}
        whole = self._learn(self._summary()) and bool(self._channels)
        if not whole and not self._learn(self._stretches()) and not self._channels:
            raise MicrogripperError(f"{path}: is damaged: its topics cannot be read")
        self.topics = tuple(dict.fromkeys(self._channels.values()))

    @property
    def damage(self) -> str | None:
        """What could not be read, once all was read."""
        if not self._damaged:
            return None
        return (
            f"{self._path.name} is damaged, cut off or was not closed, at byte {self._damaged[0]} "
            f"of {len(self._data)}: what could not be read is missing"
        )

    def blocks(self, topics: Collection[Topic]) -> Iterator[Block]:
        """The messages of some topics, those of each near the order of receipt."""
        numbers = {
            topic: [number for number, named in self._channels.items() if named == topic]
            for topic in topics
        }
        for records in self._stretches():
            self._check_topics(records)
            starts, ends = records.spans(MESSAGE)
            whole = ends - starts >= MESSAGE_HEAD
            if not np.all(whole):
                self._damaged.append(int(starts[~whole][0]))
                starts, ends = starts[whole], ends[whole]
            channels = bytes_from(records.data, starts, np.arange(0, 2)).view("<u2")[:, 0]
            for topic, among in numbers.items():
                mine = np.isin(channels, among)
                if np.any(mine):
                    first, last = starts[mine], ends[mine]
                    received = bytes_from(records.data, first, np.arange(6, 14)).view("<i8")[:, 0]
                    yield Block(topic, received, records.data, first + MESSAGE_HEAD, last)

    def close(self) -> None:
        """Let go of the file."""
        self._data = np.empty(0, np.uint8)

    def _summary(self) -> Iterable[Records]:
        """The records of the summary; nothing if the file has none, or none with topics."""
        footer = self._data[-FOOTER_SIZE - len(MAGIC) :].tobytes()
        if len(footer) < FOOTER_SIZE + len(MAGIC) or not footer.endswith(MAGIC):
            return ()
        opcode, length, start = struct.unpack_from("<BQQ", footer)
        if (opcode, length) != (FOOTER, 20) or not len(MAGIC) < start < len(self._data):
            return ()
        summary = list(Records.runs(self._data, start))
        return summary if any(CHANNEL in records.opcodes for records in summary) else ()

    def _learn(self, source: Iterable[Records]) -> bool:
        """Take topics and counts from records; whether all of them could be read."""
        self.counts.clear()
        try:
            for records in source:
                self._learn_topics(records)
                self._learn_counts(records)
        except (struct.error, UnicodeDecodeError):
            return False
        return True

    def _learn_topics(self, records: Records) -> None:
        for content in records.contents(SCHEMA):
            number, kind, definition = _schema(content)
            self._definitions[number] = kind, definition
        for content in records.contents(CHANNEL):
            number, schema, name, encoding = _channel(content)
            kind, definition = self._definitions.get(schema, UNKNOWN)
            noted = pairs_of_texts(content, 12 + len(name.encode()) + len(encoding.encode()))
            self._channels[number] = Topic(name, kind, encoding, definition, noted.get(QOS, ""))

    def _check_topics(self, records: Records) -> None:
        """What the summary told of the topics must be what stands beside the messages."""
        for opcode, agrees in ((SCHEMA, self._knows_type), (CHANNEL, self._knows_topic)):
            starts, _ = records.spans(opcode)
            for start, content in zip(starts, records.contents(opcode), strict=True):
                try:
                    known = agrees(content)
                except (struct.error, UnicodeDecodeError):
                    known = False
                if not known:
                    self._damaged.append(int(start))

    def _knows_type(self, content: bytes) -> bool:
        number, *told = _schema(content)
        return self._definitions.get(number) == tuple(told)

    def _knows_topic(self, content: bytes) -> bool:
        number, schema, name, _ = _channel(content)
        known = self._channels.get(number)
        kind, definition = self._definitions.get(schema, UNKNOWN)
        return known == Topic(name, kind) and known.definition == definition

    def _learn_counts(self, records: Records) -> None:
        for content in records.contents(STATISTICS):
            length = STATISTICS_HEAD.unpack_from(content)[-1]
            counted = content[STATISTICS_HEAD.size :][: length // 10 * 10]
            for number, count in struct.iter_unpack("<HQ", counted):
                if number in self._channels:
                    name = self._channels[number].name
                    self.counts[name] = self.counts.get(name, 0) + count

    def _stretches(self) -> Iterator[Records]:
        """All whole records of the file and, after them, of the chunks among them."""
        self._damaged.clear()
        at, size = len(MAGIC), len(self._data)
        while True:
            for records in Records.runs(self._data, at):
                yield records
                for start, end in zip(*records.spans(CHUNK), strict=True):
                    yield from self._chunk(int(start), int(end))
                at = int(records.ends[-1])
            if size - at == len(MAGIC) and self._data[at:].tobytes() == MAGIC:
                return
            self._damaged.append(at)
            following = self._next_chunk(at)
            if at + RECORD_HEAD < size and self._data[at] == CHUNK:
                # What a recorder leaves that was killed while it wrote: its first part is as good
                # as any.
                yield from self._chunk(at + RECORD_HEAD, following)
            if following == size:
                return
            at = following

    def _next_chunk(self, at: int) -> int:
        """Where the next whole chunk begins behind byte `at`, or the end of the file."""
        size = len(self._data)
        for begin in range(at + 1, size, SEARCHED_AT_ONCE):
            part = self._data[begin : begin + SEARCHED_AT_ONCE]
            for offset in np.flatnonzero(part == CHUNK):
                start = begin + int(offset)
                head = self._data[start : start + RECORD_HEAD + CHUNK_HEAD.size + 16].tobytes()
                if is_whole_chunk(head, size - start):
                    return start
        return size

    def _chunk(self, start: int, end: int) -> Iterator[Records]:
        """The records packed into the chunk whose content is data[start:end], perhaps cut off."""
        head = self._data[start : start + CHUNK_HEAD.size].tobytes()
        if len(head) < CHUNK_HEAD.size:
            self._damaged.append(start)
            return
        _, _, size, checksum, method_length = CHUNK_HEAD.unpack(head)
        at = start + CHUNK_HEAD.size + method_length
        method, length = self._data[at - method_length : at].tobytes(), self._data[at : at + 8]
        packed = self._data[at + 8 : min(end, at + 8 + int.from_bytes(length.tobytes(), "little"))]
        if method:
            try:
                plain = decompress(packed.tobytes(), method.decode(), size, checksum)
            except Exception:  # the decompressors' errors have no common class
                self._damaged.append(start)
                return
            packed = np.frombuffer(plain, np.uint8)
        runs = list(Records.runs(packed, 0))
        read = int(runs[-1].ends[-1]) if runs else 0
        if read < size:
            self._damaged.append(start)
        elif not method and checksum and crc32(packed.data) != checksum:
            self._damaged.append(start)  # any of its values may be the wrong one
            return
        yield from runs


def _schema(content: bytes) -> tuple[int, str, str]:
    """Number, name and definition of a type, empty where that is not in .msg form."""
    (number,) = struct.unpack_from("<H", content)
    name, encoding, definition = texts(content, 2, 3)
    return number, name, definition if encoding == "ros2msg" else ""


def _channel(content: bytes) -> tuple[int, int, str, str]:
    """Number, schema, topic and encoding of a channel."""
    number, schema = struct.unpack_from("<HH", content)
    name, encoding = texts(content, 4, 2)
    return number, schema, name, encoding
