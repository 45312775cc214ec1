"""The records of an MCAP file, and the pieces of which their contents are made.

The format (https://mcap.dev/spec): a file is a row of records (opcode, length, content), most of
them packed into chunks; a summary at the end repeats what the topics are.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.recordings.storage import Bytes, Integers

FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS = 0x02, 0x03, 0x04, 0x05, 0x06, 0x0B
RECORD_HEAD = 9  # bytes: opcode, length
CHUNK_HEAD = struct.Struct("<QQQII")  # first and last time, size, checksum, length of method
RECORDS_AT_ONCE = 65536
LONGEST_METHOD = 8  # characters in the name of a compression


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


def is_whole_chunk(head: bytes, room: int) -> bool:
    """Whether a record that begins with these bytes is a chunk whose lengths agree."""
    if len(head) < RECORD_HEAD + CHUNK_HEAD.size + 8:
        return False
    (length,) = struct.unpack_from("<Q", head, 1)
    method_length = CHUNK_HEAD.unpack_from(head, RECORD_HEAD)[-1]
    at = RECORD_HEAD + CHUNK_HEAD.size + method_length
    if method_length > LONGEST_METHOD or RECORD_HEAD + length > room:
        return False
    (packed,) = struct.unpack_from("<Q", head, at)
    return bool(at + 8 + packed == RECORD_HEAD + length)


def texts(content: bytes, at: int, count: int) -> list[str]:
    """`count` texts in a row from byte `at` on, each after its length."""
    found = []
    for _ in range(count):
        (length,) = struct.unpack_from("<I", content, at)
        (text,) = struct.unpack_from(f"<{length}s", content, at + 4)
        found.append(text.decode())
        at += 4 + length
    return found


def pairs_of_texts(content: bytes, at: int) -> dict[str, str]:
    """The pairs of texts from byte `at` on, after their length; those before one that is cut."""
    pairs: dict[str, str] = {}
    try:
        (length,) = struct.unpack_from("<I", content, at)
        at, end = at + 4, at + 4 + length
        while at < end:
            key, value = texts(content, at, 2)
            pairs[key] = value
            at += 8 + len(key.encode()) + len(value.encode())
    except (struct.error, UnicodeDecodeError):
        pass
    return pairs
