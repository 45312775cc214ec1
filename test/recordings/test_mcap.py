"""MCAP as other writers make it, put together by hand after its specification."""

from __future__ import annotations

import struct
from binascii import crc32
from pathlib import Path

import lz4.frame
import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings.bag import Bag

MAGIC = b"\x89MCAP0\r\n"
FLOAT64 = "std_msgs/msg/Float64"


def record(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def text(value: str) -> bytes:
    return struct.pack("<I", len(value.encode())) + value.encode()


def schema(number: int, name: str = FLOAT64, encoding: str = "ros2msg") -> bytes:
    return record(3, struct.pack("<H", number) + text(name) + text(encoding) + text("float64 data"))


def channel(number: int, topic: str, of: int = 1, encoding: str = "cdr") -> bytes:
    content = struct.pack("<HH", number, of) + text(topic) + text(encoding) + text("")
    return record(4, content)


def message(number: int, at: int) -> bytes:
    head = struct.pack("<HIQQ", number, 0, at, at)
    return record(5, head + b"\0\1\0\0" + struct.pack("<d", float(at)))


def chunk(records: bytes, method: str = "", checksum: int | None = None) -> bytes:
    packed = lz4.frame.compress(records) if method == "lz4" else records
    checksum = crc32(records) if checksum is None else checksum
    head = struct.pack("<QQQI", 0, 0, len(records), checksum) + text(method)
    return record(6, head + struct.pack("<Q", len(packed)) + packed)


def write(folder: Path, *parts: bytes) -> Path:
    """A whole file without a summary."""
    path = folder / "run.mcap"
    head = record(1, text("ros2") + text("by hand"))
    end = record(15, bytes(4)) + record(2, bytes(20))
    path.write_bytes(MAGIC + head + b"".join(parts) + end + MAGIC)
    return path


def times(path: Path, topic: str = "/a") -> tuple[list[int], tuple[str, ...]]:
    """When the topic's messages were received, and what was found damaged."""
    with Bag(path) as bag:
        chosen = [one for one in bag.topics if one.name == topic]
        found = [at for _, at, _ in bag.messages(chosen)]
        return found, bag.warnings


ANNOUNCED = schema(1) + channel(7, "/a") + channel(8, "/b")


def test_messages_outside_of_chunks(tmp_path: Path) -> None:
    parts = [message(7 + k % 2, k) for k in range(20)]
    path = write(tmp_path, ANNOUNCED, *parts)
    assert times(path) == (list(range(0, 20, 2)), ())
    assert times(path, "/b") == (list(range(1, 20, 2)), ())


@pytest.mark.parametrize("method", ["", "lz4"])
def test_chunks_with_checksums(tmp_path: Path, method: str) -> None:
    parts = [chunk(message(7, k) + message(8, k), method) for k in range(5)]
    path = write(tmp_path, chunk(ANNOUNCED, method), *parts)
    assert times(path) == (list(range(5)), ())


@pytest.mark.parametrize("method", ["", "lz4", "of the future"])
def test_a_chunk_with_a_wrong_checksum_is_passed_over_and_told(tmp_path: Path, method: str) -> None:
    good = [chunk(message(7, k)) for k in range(3)]
    bad = chunk(message(7, 99), method, checksum=12345)
    found, warnings = times(write(tmp_path, ANNOUNCED, *good, bad, chunk(message(7, 5))))
    assert found == [0, 1, 2, 5]
    assert warnings[0].startswith("run.mcap is damaged")


def test_a_topic_recorded_by_two_channels(tmp_path: Path) -> None:
    """A publisher that came back is announced again."""
    parts = [message(7, 0), channel(9, "/a"), message(9, 1), message(7, 2)]
    assert times(write(tmp_path, ANNOUNCED, *parts)) == ([0, 1, 2], ())


def test_records_to_come_are_passed_over(tmp_path: Path) -> None:
    parts = [message(7, 0), record(0x33, b"?" * 50), record(0x90, b""), message(7, 1)]
    assert times(write(tmp_path, ANNOUNCED, *parts)) == ([0, 1], ())


def test_a_message_too_short_to_be_one(tmp_path: Path) -> None:
    found, warnings = times(write(tmp_path, ANNOUNCED, message(7, 0), record(5, b"short")))
    assert found == [0]
    assert len(warnings) == 1


def test_a_length_beyond_the_end(tmp_path: Path) -> None:
    found, warnings = times(
        write(tmp_path, ANNOUNCED, message(7, 0), struct.pack("<BQ", 5, 2**63 + 5), message(7, 1))
    )
    assert found == [0]
    assert len(warnings) == 1


def test_what_the_topics_are(tmp_path: Path) -> None:
    parts = [
        schema(2, "rig/Sample", "protobuf"),
        channel(1, "/p", 2, "protobuf"),
        channel(2, "/?", 9),
    ]
    with Bag(write(tmp_path, ANNOUNCED, *parts)) as bag:
        assert [(t.name, t.type, t.encoding, t.definition) for t in bag.topics] == [
            ("/?", "unknown type", "cdr", ""),
            ("/a", FLOAT64, "cdr", "float64 data"),
            ("/b", FLOAT64, "cdr", "float64 data"),
            ("/p", "rig/Sample", "protobuf", ""),
        ]


def test_topics_that_cannot_be_read(tmp_path: Path) -> None:
    path = write(tmp_path, record(4, b"\1"))
    with pytest.raises(MicrogripperError, match="is damaged: its topics cannot be read"):
        Bag(path)


def test_a_row_of_numbers_in_bulk(tmp_path: Path) -> None:
    path = write(tmp_path, ANNOUNCED, *(message(7, k) for k in range(100)))
    with Bag(path) as bag:
        (block,) = bag.blocks(bag.topics[:1])
        assert len(block) == 100
        values = block.bytes_at(np.arange(4, 12), np.arange(100)).view("<f8")[:, 0]
        assert np.array_equal(values, np.arange(100.0))
