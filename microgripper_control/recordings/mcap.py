"""MCAP storage, read in bulk and as far as it goes.

rosbags reads MCAP message by message and refuses a file without its end, which is what a recorder
that was killed leaves behind. Here the records are found by a compiled loop, the messages stay
where they are in the file, and what is damaged is passed over and told.

The format (https://mcap.dev/spec): a file is a row of records (opcode, length, content), most of
them packed into chunks; a summary at the end repeats what the topics are.
"""

from __future__ import annotations

import struct
from binascii import crc32
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rosbags.rosbag2.storage_mcap import decompress

from microgripper_control.core.compiled import compiled
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.storage import Block, Bytes, Integers, Topic

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x02, 0x03, 0x04, 0x05, 0x06
RECORD_HEAD = 9  # bytes: opcode, length
MESSAGE_HEAD = 22  # bytes: channel, sequence, time logged, time published
CHUNK_HEAD = struct.Struct("<QQQII")  # first and last time, size, checksum, length of method
FOOTER_SIZE = RECORD_HEAD + 20
RECORDS_AT_ONCE = 65536


@compiled
def _find(data: Bytes, at: int, opcodes: Bytes, starts: Integers, ends: Integers) -> int:
    """Fill in the records from byte `at` on until the arrays or the whole records end."""
    count = 0
    while count < len(opcodes) and at + RECORD_HEAD <= len(data):
        length = 0
        for i in range(8):
            length |= np.int64(data[at + 1 + i]) << (8 * i)
        # Opcode 0 is not allowed: it is what a file system leaves in place of lost data.
        if data[at] == 0 or length < 0 or length > len(data) - at - RECORD_HEAD:
            break
        opcodes[count] = data[at]
        starts[count] = at + RECORD_HEAD
        at += RECORD_HEAD + length
        ends[count] = at
        count += 1
    return count


@dataclass(frozen=True)
class Records:
    """Whole records in a row, at least one: content i is data[starts[i]:ends[i]]."""

    data: Bytes
    opcodes: Bytes
    starts: Integers
    ends: Integers

    @classmethod
    def runs(cls, data: Bytes, at: int) -> Iterator[Records]:
        """The records from byte `at` on, thousands at a time, up to one that is not whole."""
        while True:
            size = max(0, min(RECORDS_AT_ONCE, (len(data) - at) // RECORD_HEAD))
            opcodes = np.empty(size, np.uint8)
            starts, ends = np.empty(size, np.int64), np.empty(size, np.int64)
            count = _find(data, at, opcodes, starts, ends)
            if not count:
                return
            yield cls(data, opcodes[:count], starts[:count], ends[:count])
            at = int(ends[count - 1])

    def spans(self, opcode: int) -> tuple[Integers, Integers]:
        """Where the contents of the records of one kind start and end."""
        chosen = self.opcodes == opcode
        return self.starts[chosen], self.ends[chosen]

    def contents(self, opcode: int) -> Iterator[bytes]:
        """The contents of the records of one kind."""
        for start, end in zip(*self.spans(opcode), strict=True):
            yield self.data[start:end].tobytes()


class McapFile:
    """One MCAP file, whole or not; MicrogripperError if it is none."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._data: Bytes = np.asarray(np.memmap(path, np.uint8, mode="r"))
        if self._data[: len(MAGIC)].tobytes() != MAGIC:
            raise MicrogripperError(f"{path}: is not an MCAP file")
        self._damaged: list[int] = []  # bytes at which something could not be read
        self._definitions: dict[int, tuple[str, str]] = {}  # schema -> type, its definition
        self._channels: dict[int, Topic] = {}
        try:
            for records in self._summary() or self._stretches():
                self._learn_topics(records)
        except (struct.error, UnicodeDecodeError):
            raise MicrogripperError(f"{path}: is damaged: its topics cannot be read") from None
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
            starts, ends = records.spans(MESSAGE)
            whole = ends - starts >= MESSAGE_HEAD
            if not np.all(whole):
                self._damaged.append(int(starts[~whole][0]))
                starts, ends = starts[whole], ends[whole]
            channels = records.data[starts[:, None] + np.arange(0, 2)].view("<u2")[:, 0]
            for topic, among in numbers.items():
                mine = np.isin(channels, among)
                if np.any(mine):
                    first, last = starts[mine], ends[mine]
                    received = records.data[first[:, None] + np.arange(6, 14)].view("<i8")[:, 0]
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

    def _learn_topics(self, records: Records) -> None:
        for content in records.contents(SCHEMA):
            (number,) = struct.unpack_from("<H", content)
            name, encoding, definition = _texts(content, 2, 3)
            self._definitions[number] = name, definition if encoding == "ros2msg" else ""
        for content in records.contents(CHANNEL):
            number, schema = struct.unpack_from("<HH", content)
            name, encoding = _texts(content, 4, 2)
            kind, definition = self._definitions.get(schema, ("unknown type", ""))
            self._channels[number] = Topic(name, kind, encoding, definition)

    def _stretches(self) -> Iterator[Records]:
        """All whole records of the file and, after them, of the chunks among them."""
        self._damaged.clear()
        at, size = len(MAGIC), len(self._data)
        for records in Records.runs(self._data, at):
            yield records
            for start, end in zip(*records.spans(CHUNK), strict=True):
                yield from self._chunk(int(start), int(end))
            at = int(records.ends[-1])
        if self._data[at:].tobytes() == MAGIC:
            return
        self._damaged.append(at)
        if at + RECORD_HEAD < size and self._data[at] == CHUNK:
            # What a recorder leaves that was killed while it wrote: its first part is as good as
            # any.
            yield from self._chunk(at + RECORD_HEAD, size)

    def _chunk(self, start: int, end: int) -> Iterator[Records]:
        """The records packed into the chunk whose content is data[start:end], perhaps cut off."""
        head = self._data[start : start + CHUNK_HEAD.size].tobytes()
        if len(head) < CHUNK_HEAD.size:
            self._damaged.append(start)
            return
        _, _, size, checksum, method_length = CHUNK_HEAD.unpack(head)
        at = start + CHUNK_HEAD.size + method_length + 8
        method = self._data[start + CHUNK_HEAD.size : at - 8].tobytes()
        packed = self._data[at:end]
        if method:
            try:
                plain = decompress(packed.tobytes(), method.decode(), size, checksum)
            except Exception:  # the decompressors' errors have no common class
                self._damaged.append(start)
                return
            packed = np.frombuffer(plain, np.uint8)
        elif checksum and len(packed) == size and crc32(packed.data) != checksum:
            self._damaged.append(start)
            return
        read = 0
        for records in Records.runs(packed, 0):
            yield records
            read = int(records.ends[-1])
        if read < size:
            self._damaged.append(start)


def _texts(content: bytes, at: int, count: int) -> list[str]:
    """`count` texts in a row from byte `at` on, each after its length."""
    found = []
    for _ in range(count):
        (length,) = struct.unpack_from("<I", content, at)
        (text,) = struct.unpack_from(f"<{length}s", content, at + 4)
        found.append(text.decode())
        at += 4 + length
    return found
