"""The signals that ask a process to end."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType


def ending_signals() -> tuple[signal.Signals, ...]:
    """Ctrl-C, a request to end, and a terminal that is closed, unless that is to be outlived.

    What `nohup` has started ignores SIGHUP, and shall. What a shell has started in the background
    ignores SIGINT, but is asked by it to end all the same.
    """
    outlives = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return (signal.SIGINT, signal.SIGTERM, *([] if outlives else [signal.SIGHUP]))


@contextmanager
def handled(
    signals: Iterable[signal.Signals], handler: Callable[[int, FrameType | None], None]
) -> Iterator[None]:
    """Inside, a handler takes some signals; afterwards they are taken as before."""
    before = {number: signal.signal(number, handler) for number in signals}
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)


@contextmanager
def asked_to_end() -> Iterator[list[int]]:
    """Inside, what asks to end does nothing but get into the list."""
    asked: list[int] = []
    with handled(ending_signals(), lambda number, frame: asked.append(number)):
        yield asked
