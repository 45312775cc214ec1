"""The messages of one topic in an SQLite3 file: alike ones in bulk, others row by row.

SQLite puts the rows of a range side by side itself, which takes half of the time of a Python object
for each. That asks for messages of one length in a database of UTF-8, in which the bytes of a BLOB
are passed on as they are. From the first range that is not so, or is damaged, each row is read.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Generator, Iterator
from itertools import islice

import numpy as np

from microgripper_control.recordings.storage import Block, Topic

ROWS_AT_ONCE, BYTES_AT_ONCE = 4096, 2**25
FARTHEST_LEAP = 2**40  # messages
# In the order of the table: an index may lie in a part that is lost.
ROWS = "FROM messages NOT INDEXED WHERE topic_id = ? AND rowid > ?"
FIRST_SIZE = f"SELECT length(data) {ROWS} ORDER BY rowid LIMIT 1"
# What is no BLOB is smaller than any; what is no whole number is not equal to itself as one.
SIDE_BY_SIDE = f"""
    SELECT CAST(group_concat(data, '') AS BLOB), group_concat(timestamp | 0), count(*),
        count(*) FILTER (WHERE length(data) = ? AND data >= x'' AND timestamp = timestamp | 0)
    {ROWS} AND rowid <= ?
"""


def rows_of(
    database: sqlite3.Connection, number: int, topic: Topic, damaged: Callable[[], None]
) -> Iterator[Block]:
    """The messages of topic `number`, in the order of receipt; `damaged` is called where some are.

    What can be read is read: parts that are damaged are leapt over.
    """
    after = yield from _alike(database, number, topic)
    yield from _one_by_one(database, number, topic, after, damaged)


def _alike(database: sqlite3.Connection, number: int, topic: Topic) -> Generator[Block, None, int]:
    """Blocks from the first row on, as long as all messages are alike; returns their last row."""
    after = -1
    try:
        if database.execute("PRAGMA encoding").fetchone() != ("UTF-8",):
            return after
        first = database.execute(FIRST_SIZE, [number, after]).fetchone()
        while first is not None and first[0]:
            rows = max(1, min(ROWS_AT_ONCE, BYTES_AT_ONCE // first[0]))
            here = [*first, number, after, after + rows]
            data, times, count, alike = database.execute(SIDE_BY_SIDE, here).fetchone()
            if not count or alike < count or len(data) != count * first[0]:
                break
            received = np.fromstring(times, np.int64, sep=",")
            yield Block.alike(topic, received, np.frombuffer(data, np.uint8))
            after += rows
    except sqlite3.Error:
        pass  # what is damaged is found again row by row
    return after


def _one_by_one(
    database: sqlite3.Connection,
    number: int,
    topic: Topic,
    after: int,
    damaged: Callable[[], None],
) -> Iterator[Block]:
    """Blocks of the rows behind row `after`."""
    leap = 1
    while leap < FARTHEST_LEAP:
        count = 0
        try:
            query = f"SELECT timestamp, data {ROWS} ORDER BY rowid"
            cursor = database.execute(query, [number, after])
            while True:
                received: list[int] = []
                messages: list[bytes] = []
                size = 0
                try:
                    # One row is let go of before the next: keeping them would cost twice.
                    for at, message in islice(cursor, ROWS_AT_ONCE):
                        received.append(at)
                        messages.append(message)
                        size += len(message) if isinstance(message, bytes) else 0
                        if size > BYTES_AT_ONCE:
                            break
                finally:  # what comes before an error is good
                    if received:
                        count += len(received)
                        leap = 1
                        yield from _block(topic, received, messages, damaged)
                if not received:
                    return
        except (sqlite3.Error, OverflowError):
            damaged()
            after = _row(database, number, after, count) + leap
            leap *= 2


def _row(database: sqlite3.Connection, number: int, after: int, count: int) -> int:
    """Which row of a topic comes so many after another; all up to it could be read."""
    if not count:
        return after
    query = f"SELECT rowid {ROWS} ORDER BY rowid LIMIT 1 OFFSET ?"
    return int(database.execute(query, [number, after, count - 1]).fetchone()[0])


def _block(
    topic: Topic, received: list[int], messages: list[bytes], damaged: Callable[[], None]
) -> Iterator[Block]:
    try:
        yield Block.of(topic, received, messages)
    except TypeError:  # a column of SQLite's may hold anything
        damaged()
        rows = zip(received, messages, strict=True)
        good = [row for row in rows if isinstance(row[0], int) and isinstance(row[1], bytes)]
        if good:
            yield Block.of(topic, *zip(*good, strict=True))
