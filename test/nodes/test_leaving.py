from __future__ import annotations

import subprocess
import sys
import time

import pytest

PROGRAM = """
import ctypes, time
from microgripper_control.nodes import leaving
print("worked", end=""); {before}
with leaving.no_longer_than({seconds}, 7):
    {what}
"""
HANGS = "ctypes.PyDLL(None).sleep(60)"  # keeps the interpreter's lock


def ended(what: str, before: str = "") -> subprocess.CompletedProcess[str]:
    program = PROGRAM.format(seconds=0.2, what=what, before=before)
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=50, check=False
    )


@pytest.mark.parametrize("what", ["time.sleep(60)", HANGS])
def test_a_process_that_hangs_at_its_end_is_ended_and_says_where(what: str) -> None:
    process = ended(what)
    assert process.returncode == 7
    assert 'File "<string>", line 6' in process.stderr
    assert process.stdout == "worked", "nothing that was printed is lost"


def test_a_process_that_ends_in_time_is_left_alone() -> None:
    process = ended("pass\ntime.sleep(1.0)")
    assert (process.returncode, process.stdout, process.stderr) == (0, "worked", "")


def test_a_system_without_such_a_timer_still_ends_what_hangs() -> None:
    assert ended(HANGS, before="leaving._end_later = lambda *_: False").returncode == 1


@pytest.mark.parametrize(("late", "seconds"), [("None", 20.0), (HANGS, 0.2)])
def test_the_end_of_the_interpreter_is_watched_as_well(late: str, seconds: float) -> None:
    """As by what a module does when it is taken down."""
    program = f"""
import atexit, ctypes, sys
from microgripper_control.nodes import leaving
atexit.register(lambda: {late})
print("worked", flush=True)
leaving.end_within({seconds}, 7)
sys.exit(7)
"""
    started = time.monotonic()
    process = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=50, check=False
    )
    assert (process.returncode, process.stdout, process.stderr) == (7, "worked\n", "")
    assert time.monotonic() - started < 15.0
