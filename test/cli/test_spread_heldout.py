"""`--heldout A B` is what people type; the parser wants `--heldout A --heldout B`."""

from __future__ import annotations

import pytest

from microgripper_control.cli.diagnose import spread_heldout


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("a --heldout b c", "a --heldout b --heldout c"),
        ("a --heldout=b c", "a --heldout b --heldout c"),
        ("--heldout b c --out d e", "--heldout b --heldout c --out d e"),
        ("a --heldout", "a --heldout"),
        ("a --heldout --model m", "a --model m --heldout"),  # the parser asks for its value
        ("--heldout --heldout b", "--heldout b --heldout"),
        ("a b --out c", "a b --out c"),
    ],
)
def test_it_is_spread(typed: str, meant: str) -> None:
    assert spread_heldout(typed.split()) == meant.split()
