"""Numbers out of serialized messages, thousands at once.

The messages of a topic nearly always share one layout. It is worked out for the first of a block,
the others are compared with it, and the numbers are read from all that agree in a few array
operations; a message that differs is worked out by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from rosbags.interfaces.typing import Typesdict

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.layout import Layout, LayoutError, Place, types_of
from microgripper_control.recordings.storage import Block, Integers, Topic

# Picks the numbers that are wanted out of a layout; None, read as NaN, where one may be missing.
Pick = Callable[[Layout], Sequence[Place | None]]


def values_by_block(bag: Bag, topic: Topic, pick: Pick) -> Iterator[tuple[Integers, Array]]:
    """The times of receipt, ns, and the numbers that `pick` wants of every message of a topic.

    Block by block, near the order of receipt, in shapes (messages,) and (messages, numbers).
    MicrogripperError, with the index of the message, where one is damaged or lacks a number.
    """
    before = 0
    try:
        types = types_of(topic)
        for block in bag.blocks([topic]):
            yield block.received, block_values(block, types, pick, before)
            before += len(block)
    except LayoutError as error:
        raise MicrogripperError(f"{bag.path}: topic {topic} {error}") from None


def block_values(block: Block, types: Typesdict, pick: Pick, before: int) -> Array:
    """The numbers of one block; `before` it came so many messages."""

    def work_out(index: int) -> tuple[Layout, Sequence[Place | None]]:
        try:
            layout = Layout.of(block.message(index), block.topic.type, types)
            return layout, pick(layout)
        except LayoutError as error:
            raise LayoutError(f"in message {before + index} {error}") from None

    layout, places = work_out(0)
    values = np.full((len(block), len(places)), np.nan)
    alike = block.like_first(np.array(layout.fixed), layout.size)
    _fill(values, block, np.flatnonzero(alike), places)
    for index in np.flatnonzero(~alike):
        _, places = work_out(int(index))
        _fill(values, block, np.array([index]), places)
    return values


def _fill(values: Array, block: Block, rows: Integers, places: Sequence[Place | None]) -> None:
    for column, place in enumerate(places):
        if place is not None:
            width = np.arange(np.dtype(place.dtype).itemsize)
            raw = block.bytes_at(place.offset + width, rows)
            values[rows, column] = raw.view(place.dtype)[:, 0]
