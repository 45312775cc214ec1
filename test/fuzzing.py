"""Bytes and values that nobody would write, drawn by hypothesis."""

from __future__ import annotations

import struct

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

BIG = [0, 1, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**53, 2**63 - 1, 2**63, 2**64 - 1]
NUMBERS = [struct.pack(form, n) for n in BIG for form in ("<Q", ">Q")] + [
    struct.pack(form, n) for n in BIG if n < 2**32 for form in ("<I", ">I")
]
PIECES = st.binary(min_size=1, max_size=8) | st.sampled_from(NUMBERS)
KINDS = ["put", "insert", "remove", "repeat", "cut"]
MUTATIONS = st.lists(
    st.tuples(st.sampled_from(KINDS), st.integers(0, 2**24), PIECES), min_size=1, max_size=4
)

NASTY_TEXTS = st.sampled_from(
    [
        "",
        "\n",
        "\x1b[2J",
        "\0",
        "../../x",
        "/etc/passwd",
        "nan",
        "1e999",
        "-inf",
        "9" * 5000,
        "µ\u202e",
    ]
)
SCALARS = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | NASTY_TEXTS
    | st.dates()
    | st.binary(max_size=8)
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(SCALARS, inner, max_size=4),
    max_leaves=8,
)

# As many examples as the profile asks for: 100, with --hypothesis-profile=chaos five times that.
fuzzed = settings(deadline=None, suppress_health_check=list(HealthCheck))


def mutated(content: bytes, mutations: list[tuple[str, int, bytes]]) -> bytes:
    """A file to which all of that has happened."""
    for kind, where, piece in mutations:
        at = where % (len(content) + 1)
        head, tail = content[:at], content[at:]
        if kind == "put":
            content = head + piece + tail[len(piece) :]
        elif kind == "insert":
            content = head + piece + tail
        elif kind == "remove":
            content = head + tail[len(piece) :]
        elif kind == "repeat":
            content = head + tail[: 8 * len(piece)] + tail
        else:
            content = head
    return content
