"""The end of a process: waited for, but not for ever.

Now and then a process that has done all its work never comes back from the middleware's end, which
keeps the interpreter's lock meanwhile: no Python runs then, no thread and no signal handler.
Whoever waits for it, a launch file or a script, would wait as long.
"""

from __future__ import annotations

import ctypes
import faulthandler
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

SIGEV_THREAD = 2  # of timer_create(2): a function is called in a thread of its own
TOLD = 0.25  # s, for saying where it hangs


class _Event(ctypes.Structure):
    """struct sigevent of sigevent(3type)."""

    _fields_ = (
        ("value", ctypes.c_void_p),
        ("signal", ctypes.c_int),
        ("notify", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("room", ctypes.c_char * 32),
    )


class _Times(ctypes.Structure):
    """struct itimerspec: how often after the first time, and when that is; s and ns."""

    _fields_ = tuple((name, ctypes.c_long) for name in ("every", "every_ns", "first", "first_ns"))


@contextmanager
def no_longer_than(seconds: float, status: int) -> Iterator[None]:
    """End the process with `status` if what is done inside takes longer, and say where it hangs.

    With status 1 where the system has no timer for it. What the interpreter does afterwards is for
    `end_within`.
    """
    with suppress(ValueError, OSError):
        sys.stdout.flush()  # nothing that was printed is lost
    library, timer = ctypes.CDLL(None), ctypes.c_void_p()
    timed = _end_later(library, timer, seconds + TOLD, status)
    try:
        with suppress(ValueError, RuntimeError, OSError):  # where standard error is no file
            faulthandler.dump_traceback_later(seconds, exit=not timed)
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
        if timed:
            library.timer_delete(timer)


def end_within(seconds: float, status: int) -> None:
    """End the process with `status` if it has not ended by itself, where the system has a timer.

    To be called last: it is not called off. The middleware may hang while the interpreter ends.
    """
    _end_later(ctypes.CDLL(None), ctypes.c_void_p(), seconds, status)


def _end_later(library: ctypes.CDLL, timer: ctypes.c_void_p, seconds: float, status: int) -> bool:
    """Have the C library end the process, which needs no lock; whether the system has a timer."""
    end = ctypes.cast(library._exit, ctypes.c_void_p).value
    event = _Event(value=status, notify=SIGEV_THREAD, function=end)
    create = getattr(library, "timer_create", None)
    if not create or create(time.CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)):
        return False
    whole, part = divmod(seconds, 1.0)
    times = _Times(first=int(whole), first_ns=int(1e9 * part))
    library.timer_settime(timer, 0, ctypes.byref(times), None)
    return True
