"""Which signals ask a process to end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from microgripper_control.cli.stopping import interruptible
from microgripper_control.core.ending import ending_signals

ALL = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def test_a_closed_terminal_asks_to_end_unless_that_is_to_be_outlived(hangup: None) -> None:
    assert ending_signals() == ALL
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    assert ending_signals() == ALL[:2]


def test_what_runs_in_the_background_is_asked_by_an_interrupt_all_the_same(hangup: None) -> None:
    """A shell that starts something in the background has it ignore SIGINT."""
    script = "from microgripper_control.core.ending import ending_signals as s; print(len(s()))"
    command = f"'{sys.executable}' -c '{script}' & wait"
    said = subprocess.run(["/bin/sh", "-c", command], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "3"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_command_is_interrupted_by_either(hangup: None, number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with pytest.raises(KeyboardInterrupt), interruptible():
        os.kill(os.getpid(), number)
    assert signal.getsignal(number) == before
