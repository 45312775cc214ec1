"""The end of a process: waited for, but not for ever.

Once, under load, a process that had done all its work never came back from the middleware's end.
Whoever waits for it, a launch file or a script, would wait as long.
"""

from __future__ import annotations

import faulthandler
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Timer


@contextmanager
def no_longer_than(seconds: float, status: int) -> Iterator[None]:
    """End the process with `status` if what is done inside takes longer, and say where it hangs.

    What hangs without letting other threads run is ended after twice as long, with status 1. What
    the interpreter does afterwards is not watched.
    """
    guard = Timer(seconds, _give_up, [status])
    guard.daemon = True
    try:
        guard.start()
        with suppress(ValueError, RuntimeError, OSError):  # where standard error is no file
            faulthandler.dump_traceback_later(2.0 * seconds, exit=True)
        yield
    finally:
        guard.cancel()
        faulthandler.cancel_dump_traceback_later()


def _give_up(status: int) -> None:
    try:
        print("the process does not end by itself; it is ended here:", file=sys.stderr, flush=True)
        faulthandler.dump_traceback()
        sys.stdout.flush()
    finally:
        os._exit(status)
