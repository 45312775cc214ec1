"""Real-time scheduling is asked for, and refused with a remedy."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable

import pytest

from microgripper_control.core.realtime import go_first, refusal


def test_all_threads_go_first_and_no_child(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[int, tuple[int, int]] = {}

    def note(thread: int, policy: int, given: os.sched_param) -> None:
        asked[thread] = policy, given.sched_priority

    monkeypatch.setattr("os.sched_setscheduler", note)
    assert go_first(20) is None
    assert os.getpid() in asked
    assert set(asked.values()) == {(os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, 20)}


@pytest.mark.parametrize("ask", [go_first, refusal])
def test_a_refusal_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, ask: Callable[[int], str | None]
) -> None:
    def refuse(thread: int, policy: int, given: os.sched_param) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr("os.sched_setscheduler", refuse)
    assert ask(20) == "Operation not permitted; see the limit rtprio"


def test_to_ask_leaves_this_process_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int]] = []

    def note(thread: int, policy: int, given: os.sched_param) -> None:
        asked.append((thread, threading.get_native_id()))

    monkeypatch.setattr("os.sched_setscheduler", note)
    assert refusal(20) is None
    ((thread, own),) = asked
    assert thread == 0
    assert own != threading.get_native_id()


def test_elsewhere_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("os.sched_setscheduler")
    assert go_first(20) == "this system has no SCHED_FIFO"
