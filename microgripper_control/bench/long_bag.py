"""Writes a long MCAP of `joint_states` at once: message by message it would take minutes.

The format: https://mcap.dev/spec. Not chunked, without a summary; every message is alike in length.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from microgripper_control.recordings.bag_recording import JOINT, JOINT_STATE
from microgripper_control.recordings.mcap import MAGIC
from microgripper_control.recordings.mcap_records import CHANNEL, FOOTER, MESSAGE, SCHEMA

HEADER, DATA_END = 0x01, 0x0F
AT_ONCE = 100_000  # messages
PERIOD = 1_000_000  # ns
MESSAGES = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("logged", "<u8"),
        ("published", "<u8"),
        ("encoding", "S4"),
        ("sec", "<i4"),
        ("nanosec", "<u4"),
        ("names", "S32"),  # of the frame, which has none, of the joint, and one position
        ("position", "<f8"),
        ("velocity_count", "<u8"),
        ("velocity", "<f8"),
        ("effort_count", "<u8"),
        ("effort", "<f8"),
    ]
)


def write_long_bag(path: Path, samples: int) -> None:
    """One MCAP file: a slow sine as the voltage, V, and its 1e-7 as the displacement, m."""
    name = f"{JOINT}\0".encode()
    names = struct.pack("<I4xII", 1, 1, len(name)) + name.ljust(8, b"\0")
    block = np.zeros(AT_ONCE, MESSAGES)
    block["opcode"], block["channel"] = MESSAGE, 1
    block["length"] = MESSAGES.itemsize - 9
    block["encoding"] = b"\0\1\0\0"
    block["names"] = names + struct.pack("<I", 1)
    block["velocity_count"] = block["effort_count"] = 1
    with path.open("wb") as file:
        file.write(MAGIC)
        file.write(_record(HEADER, _text("ros2") + _text("")))
        file.write(
            _record(
                SCHEMA, struct.pack("<H", 1) + _text(JOINT_STATE) + _text("ros2msg") + _text("")
            )
        )
        file.write(
            _record(
                CHANNEL,
                struct.pack("<HH", 1, 1)
                + _text("joint_states")
                + _text("cdr")
                + struct.pack("<I", 0),
            )
        )
        for begin in range(0, samples, AT_ONCE):
            k = np.arange(begin, min(begin + AT_ONCE, samples))
            part = block[: len(k)]
            part["logged"] = part["published"] = PERIOD * k
            part["sec"], part["nanosec"] = np.divmod(PERIOD * k, 10**9)
            part["effort"] = 50.0 * (1.0 - np.cos(1e-3 * k))
            part["position"] = 1e-7 * part["effort"]
            file.write(part.tobytes())
        file.write(_record(DATA_END, bytes(4)) + _record(FOOTER, bytes(20)) + MAGIC)


def _record(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def _text(text: str) -> bytes:
    return struct.pack("<I", len(text)) + text.encode()
