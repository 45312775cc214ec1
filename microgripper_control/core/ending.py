"""The signals that ask a process to end."""

from __future__ import annotations

import signal


def ending_signals() -> tuple[signal.Signals, ...]:
    """Ctrl-C, a request to end, and a terminal that is closed, unless that is to be outlived.

    What `nohup` has started ignores SIGHUP, and shall. What a shell has started in the background
    ignores SIGINT, but is asked by it to end all the same.
    """
    outlives = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return (signal.SIGINT, signal.SIGTERM, *([] if outlives else [signal.SIGHUP]))
