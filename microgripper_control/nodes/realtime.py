"""Real-time scheduling of a node's threads.

A tick comes on time only if its thread gets a core at that moment. Under Linux's usual scheduler it
shares the cores with whatever else runs; under SCHED_FIFO it goes first. That takes the permission:
root, CAP_SYS_NICE, or a line `USER - rtprio 50` in /etc/security/limits.conf.
"""

from __future__ import annotations

import os
from pathlib import Path

THREADS = Path("/proc/self/task")
HIGHEST = 98  # one below the kernel's own


def go_first(priority: int) -> str | None:
    """Put all threads of this process, the middleware's too, under SCHED_FIFO.

    Processes that it starts later are scheduled as usual. Returns why it was not done, or None.
    """
    if not hasattr(os, "sched_setscheduler"):
        return "this system has no SCHED_FIFO"
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        for thread in THREADS.iterdir():
            os.sched_setscheduler(int(thread.name), policy, os.sched_param(priority))
    except OSError as error:
        return f"{error.strerror}; see the limit rtprio"
    return None
