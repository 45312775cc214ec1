"""The end of a process: waited for, but not for ever.

Now and then, under load, a process that had done all its work never came back from the middleware's
end. Whoever waits for it, a launch file or a script, would wait as long.
"""

from __future__ import annotations

import faulthandler
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer


@contextmanager
def no_longer_than(seconds: float, status: int) -> Iterator[None]:
    """End the process with `status` if what is done inside takes longer, and say where it hangs.

    What hangs without letting other threads run is ended after twice as long, with status 1.
    """
    guard = Timer(seconds, _give_up, [status])
    guard.daemon = True
    guard.start()
    faulthandler.dump_traceback_later(2.0 * seconds, exit=True)
    try:
        yield
    finally:
        guard.cancel()
        faulthandler.cancel_dump_traceback_later()


def _give_up(status: int) -> None:
    print("the process does not end by itself; it is ended here:", file=sys.stderr, flush=True)
    faulthandler.dump_traceback()
    sys.stdout.flush()
    os._exit(status)
