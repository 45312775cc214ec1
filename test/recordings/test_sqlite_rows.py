"""Messages read side by side are those read row by row, whatever the table holds."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from unittest.mock import patch

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from microgripper_control.recordings import sqlite_rows
from microgripper_control.recordings.sqlite_rows import rows_of
from microgripper_control.recordings.storage import Topic

TOPIC = Topic("a", "std_msgs/msg/Float64")
TIMES = st.integers(-(2**63), 2**63 - 1)
ALIKE = st.tuples(st.just(1), TIMES, st.binary(min_size=4, max_size=4))
ANY = st.tuples(
    st.integers(1, 2),
    TIMES | st.just("x") | st.just(1.5) | st.none(),
    st.binary(max_size=6) | st.just("text") | st.just(5) | st.none(),
)


def table(rows: list[tuple[object, ...]], encoding: str) -> sqlite3.Connection:
    database = sqlite3.connect(":memory:")
    database.execute(f"PRAGMA encoding = '{encoding}'")
    database.execute(
        "CREATE TABLE messages"
        "(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)"
    )
    database.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", rows)
    return database


def read(database: sqlite3.Connection, damage: list[str]) -> list[tuple[int, bytes]]:
    return [
        (int(block.received[i]), block.message(i))
        for block in rows_of(database, 1, TOPIC, lambda: damage.append("some"))
        for i in range(len(block))
    ]


@pytest.mark.parametrize("encoding", ["UTF-8", "UTF-16"])
@example(alike=[], others=[(1, None, b"")])
@example(alike=[], others=[(1, 0, None)])
@given(alike=st.lists(ALIKE, max_size=12), others=st.lists(ANY, max_size=6))
def test_a_table_of_anything(
    encoding: str, alike: list[tuple[object, ...]], others: list[tuple[object, ...]]
) -> None:
    rows = [*alike, *others, *alike]
    good = [
        (at, data)
        for number, at, data in rows
        if number == 1 and isinstance(at, int) and isinstance(data, bytes)
    ]
    damage: list[str] = []
    with (
        closing(table(rows, encoding)) as database,
        patch.object(sqlite_rows, "ROWS_AT_ONCE", 4),
    ):
        assert read(database, damage) == good
    of_the_topic = [row for row in rows if row[0] == 1]
    assert bool(damage) == (len(of_the_topic) > len(good))


def test_what_is_alike_is_not_read_row_by_row() -> None:
    rows: list[tuple[object, ...]] = [(1, at, bytes([at, 0, 255, 0])) for at in range(10)]
    with (
        closing(table(rows, "UTF-8")) as database,
        patch.object(sqlite_rows, "_block", side_effect=AssertionError("row by row")),
    ):
        assert read(database, []) == [(at, data) for _, at, data in rows]
