"""Where the fields of a serialized message lie.

ROS 2 serializes messages in the Common Data Representation (CDR; OMG formal/02-06-51, chapter 15):
four bytes that name the encoding, then the fields in order, each aligned to its own size, texts and
sequences after their lengths.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.interfaces.typing import FieldDesc, Typesdict
from rosbags.typesys import TypesysError

from microgripper_control.recordings.message_types import types_with
from microgripper_control.recordings.storage import COMPRESSED, Topic

HEAD = 4  # bytes: the encoding, then options
BYTE_ORDERS = {b"\0\0": ">", b"\0\1": "<"}
WIDTHS = (1, 2, 4, 8)  # bytes
NUMBERS = {
    **dict.fromkeys(("bool", "byte", "char"), "u1"),
    **{f"{kind}{8 * width}": f"{kind[0]}{width}" for kind in ("int", "uint") for width in WIDTHS},
    "float32": "f4",
    "float64": "f8",
}


class LayoutError(Exception):
    """A message is not what its type says, or has not the field that is asked for."""


@dataclass(frozen=True)
class Place:
    """A number in a message from byte `offset` on, or `count` of them in a row."""

    offset: int
    dtype: str
    count: int | None = None


@dataclass(frozen=True)
class Layout:
    """What one message holds where; all that are alike in the bytes at `fixed` share it.

    `places` holds the numbers by their paths (`header.stamp.sec`, `effort`, `wrench.force.z`),
    `texts` the strings, `size` is the length of the message in bytes.
    """

    places: dict[str, Place]
    texts: dict[str, list[str]]
    fixed: list[int]
    size: int

    @classmethod
    def of(cls, message: bytes, kind: str, types: Typesdict) -> Layout:
        """Work out a message of the type `kind`; LayoutError if it is none."""
        walk = _Walk(message, types)
        try:
            walk.message(kind, "")
        except (struct.error, RecursionError):
            raise LayoutError("is shorter than its type asks for") from None
        except KeyError as error:
            raise LayoutError(f"holds a field of unknown type {error}") from None
        if walk.at > len(message):
            raise LayoutError("is shorter than its type asks for")
        return cls(walk.places, walk.texts, walk.fixed, walk.at)

    def place(self, path: str) -> Place:
        """The number at a path such as `data` or `position[0]`; LayoutError if there is none."""
        found, index = self.places.get(path), 0
        if found is None and (element := re.fullmatch(r"(.*)\[(\d+)\]", path)):
            found, index = self.places.get(element[1]), int(element[2])
            if found is not None and index >= (found.count or 0):
                raise LayoutError(f"has {found.count or 0} numbers in {element[1]}, none is {path}")
        elif found is not None and found.count == 0:
            raise LayoutError(f"has no number in {path}: it is empty")
        elif found is not None and found.count not in (None, 1):
            raise LayoutError(f"has {found.count} numbers in {path}; choose one, as {path}[0]")
        if found is None:
            raise LayoutError(f"has no number {path}; it has {', '.join(self.places) or 'none'}")
        return Place(found.offset + index * np.dtype(found.dtype).itemsize, found.dtype)


class _Walk:
    """Goes through a message field by field; `at` is the byte it has come to."""

    def __init__(self, message: bytes, types: Typesdict) -> None:
        if message.startswith(COMPRESSED):
            raise LayoutError("is compressed by rosbag2, and no metadata.yaml says so")
        if message[:2] not in BYTE_ORDERS:
            raise LayoutError("is not plain CDR")
        self.places: dict[str, Place] = {}
        self.texts: dict[str, list[str]] = {}
        self.fixed = [0, 1]
        self.at = HEAD
        self._bytes = message
        self._types = types
        self._order = BYTE_ORDERS[message[:2]]

    def message(self, kind: str, prefix: str) -> None:
        for name, description in self._types[kind][1]:
            if self.at > len(self._bytes):
                raise LayoutError("is shorter than its type asks for")
            self._field(description, prefix + name)

    def _field(self, description: FieldDesc, path: str) -> None:
        if description[0] is Nodetype.NAME:
            self.message(description[1], f"{path}.")
        elif description[0] is Nodetype.BASE:
            self._values(description[1][0], path, None)
        else:
            inner, size = description[1]
            count = size if description[0] is Nodetype.ARRAY else self._length()
            if count > len(self._bytes):
                raise LayoutError("is shorter than its type asks for")
            if inner[0] is Nodetype.BASE:
                self._values(inner[1][0], path, count)
            else:
                for index in range(count):
                    self.message(inner[1], f"{path}[{index}].")

    def _values(self, base: str, path: str, count: int | None) -> None:
        if base == "string":
            self.texts[path] = [self._text() for _ in range(1 if count is None else count)]
            return
        code = NUMBERS[base]
        if count != 0:  # nothing is aligned for nothing
            self._align(int(code[1]))
        self.places[path] = Place(self.at, self._order + code, count)
        self.at += int(code[1]) * (1 if count is None else count)

    def _align(self, width: int) -> None:
        self.at += (HEAD - self.at) % width

    def _length(self) -> int:
        self._align(4)
        (length,) = struct.unpack_from(f"{self._order}I", self._bytes, self.at)
        self._fix(4)
        return int(length)

    def _text(self) -> str:
        length = self._length()
        if length > len(self._bytes):
            raise LayoutError("is shorter than its type asks for")
        start = self.at
        self._fix(length)
        return self._bytes[start : self.at].rstrip(b"\0").decode(errors="replace")

    def _fix(self, count: int) -> None:
        """Pass over bytes that all messages of this layout share."""
        self.fixed.extend(range(self.at, self.at + count))
        self.at += count


def types_of(topic: Topic) -> Typesdict:
    """The fields of the topic's type and of those it is made of, as the bag says, or else Jazzy.

    Raises LayoutError if neither does, or the messages are not in CDR.
    """
    if topic.encoding != "cdr":
        raise LayoutError(f"is encoded as {topic.encoding!r}; only 'cdr' is read")
    try:
        return types_with(topic.type, topic.definition)
    except TypesysError as error:
        raise LayoutError(str(error)) from None
