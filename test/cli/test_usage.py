"""A mistyped command line gets one line that says what to type instead."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("identify", "x.csv", "--out", "y"), "'--model'"),
        (("identify", "--modell", "x"), "--modell"),
        (("identfy",), "identfy"),
        (("simulate", "--hold", "second", "x.csv"), "second"),
        (("validate", "--seed", "-1", "--out", "x"), "--seed"),
        (("validate", "--jobs", "0", "--out", "x"), "-1 is one a core"),
    ],
)
def test_bad_usage_is_one_line(
    microgripper: Callable[..., Any], words: tuple[str, ...], says: str
) -> None:
    ran = microgripper(*words)
    assert (ran.status, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert says in ran.err
    assert ran.err.endswith("--help\n")


def test_no_arguments_are_a_question_for_help(microgripper: Callable[..., Any]) -> None:
    ran = microgripper()
    assert (ran.status, ran.err) == (2, "")
    assert "identify" in ran.out


def test_help_is_no_error(microgripper: Callable[..., Any]) -> None:
    ran = microgripper("identify", "--help")
    assert (ran.status, ran.err) == (0, "")
    assert "--model" in ran.out


def test_a_name_that_no_file_can_have_is_one_line(microgripper: Callable[..., Any]) -> None:
    ran = microgripper("identify", "r.csv", "--model", "m" * 300, "--out", "y")
    assert (ran.status, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert "too long" in ran.err


def test_an_option_without_its_value_is_one_line(microgripper: Callable[..., Any]) -> None:
    ran = microgripper("diagnose", "x.csv", "--heldout", "--model", "m", "--out", "y")
    assert (ran.status, ran.out, ran.err.count("\n")) == (2, "", 1)
    assert "--heldout" in ran.err
