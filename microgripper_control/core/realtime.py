"""Real-time scheduling of a process's threads.

A tick comes on time only if its thread gets a core at that moment. Under Linux's usual scheduler it
shares the cores with whatever else runs; under SCHED_FIFO it goes first. That takes the permission:
root, CAP_SYS_NICE, or a line `USER - rtprio 50` in /etc/security/limits.conf.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

THREADS = Path("/proc/self/task")
HIGHEST = 98  # one below the kernel's own
OWN = 0  # the thread that asks


def go_first(priority: int) -> str | None:
    """Put all threads of this process, the middleware's too, under SCHED_FIFO.

    Processes that it starts later are scheduled as usual. Returns why it was not done, or None.
    """
    return _put_first(_all_threads(), priority)


def refusal(priority: int) -> str | None:
    """Why neither this process nor one that it starts could go first, or None if they could.

    It is asked for a thread that ends with this, so that nothing stays scheduled otherwise.
    """
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(_put_first, [OWN], priority).result()


def _all_threads() -> Iterator[int]:
    for thread in THREADS.iterdir():
        yield int(thread.name)


def _put_first(threads: Iterable[int], priority: int) -> str | None:
    if not hasattr(os, "sched_setscheduler"):
        return "this system has no SCHED_FIFO"
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        for thread in threads:
            os.sched_setscheduler(thread, policy, os.sched_param(priority))
    except OSError as error:
        return f"{error.strerror}; see the limit rtprio"
    return None
