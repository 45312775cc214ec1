"""What a storage file of a rosbag2 gives: its topics, and their messages in blocks.

Recordings run to many millions of messages, too many to hold one Python object each: a block keeps
thousands of serialized messages side by side in one array of bytes.
"""

from __future__ import annotations

from array import array
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.compiled import compiled

COMPRESSED = b"\x28\xb5\x2f\xfd"  # how all begins that zstd made, rosbag2's only compression

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]


@compiled
def _gather(data: Bytes, starts: Integers, offsets: Integers, found: Bytes) -> None:
    """Fill in found[i, j] = data[starts[i] + offsets[j]], five times as fast as indexing does."""
    for i in range(len(starts)):
        for j in range(len(offsets)):
            found[i, j] = data[starts[i] + offsets[j]]


def bytes_from(data: Bytes, starts: Integers, offsets: Integers) -> Bytes:
    """The bytes at `offsets` behind each of `starts`, shape (starts, offsets)."""
    found = np.empty((len(starts), len(offsets)), np.uint8)
    _gather(data, starts, offsets, found)
    return found


@compiled
def _compare(
    data: Bytes, starts: Integers, ends: Integers, offsets: Integers, size: int, found: Mask
) -> None:
    """Fill in found[i]: data from starts[i] to ends[i] holds `size`, and at `offsets` the first's.

    Offsets lie below `size`.
    """
    for i in range(len(starts)):
        found[i] = ends[i] - starts[i] >= size
        for j in range(len(offsets)):
            if not found[i]:
                break
            found[i] = data[starts[i] + offsets[j]] == data[starts[0] + offsets[j]]


@dataclass(frozen=True)
class Topic:
    """A topic as recorded; two of the same name and type are the same."""

    name: str
    type: str
    encoding: str = field(default="cdr", compare=False)
    definition: str = field(default="", compare=False)  # of the type, in .msg form, if known
    qos: str = field(default="", compare=False)  # offered by its publishers, as rosbag2's YAML

    def __str__(self) -> str:
        return f"{self.name} ({self.type})"


@dataclass(frozen=True)
class Block:
    """Messages of one topic: the i-th, received at `received[i]` ns, is data[starts[i]:ends[i]]."""

    topic: Topic
    received: Integers
    data: Bytes
    starts: Integers
    ends: Integers

    @classmethod
    def of(cls, topic: Topic, received: Sequence[int], messages: Sequence[bytes]) -> Block:
        """Put messages side by side; TypeError where one is not what it should be."""
        ends = np.cumsum(np.fromiter(map(len, messages), np.int64, len(messages)))
        data = np.frombuffer(b"".join(messages), dtype=np.uint8)
        starts = np.append(np.int64(0), ends[:-1])
        return cls(topic, np.array(array("q", received)), data, starts, ends)

    @classmethod
    def alike(cls, topic: Topic, received: Integers, data: Bytes) -> Block:
        """Messages that lie side by side and are all of one length."""
        size = len(data) // len(received)
        starts = size * np.arange(len(received))
        return cls(topic, received, data, starts, starts + size)

    def __len__(self) -> int:
        return len(self.received)

    def message(self, index: int) -> bytes:
        """One serialized message."""
        return self.data[self.starts[index] : self.ends[index]].tobytes()

    def like_first(self, offsets: Integers, size: int) -> Mask:
        """Which messages have at least `size` bytes, and at `offsets` those of the first.

        Shape (messages,). The first has so many, and offsets lie among them.
        """
        found = np.empty(len(self), np.bool_)
        _compare(self.data, self.starts, self.ends, offsets, size, found)
        return found

    def bytes_at(self, offsets: Integers, rows: Integers) -> Bytes:
        """The bytes at `offsets` of the messages `rows`, shape (rows, offsets)."""
        return bytes_from(self.data, self.starts[rows], offsets)


class StorageFile(Protocol):
    """One file of a bag; `storage` is rosbag2's name of the format."""

    storage: str
    topics: tuple[Topic, ...]

    @property
    def counts(self) -> dict[str, int]:
        """The messages by topic that the file itself says it has, empty where it does not."""
        ...

    @property
    def damage(self) -> str | None:
        """What could not be read, once all blocks were."""
        ...

    def blocks(self, topics: Collection[Topic]) -> Iterator[Block]:
        """The messages of some topics, those of each near the order of receipt."""
        ...

    def close(self) -> None:
        """Let go of the file."""
        ...
