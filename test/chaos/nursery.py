"""Starts the real nodes by fork, from a process that has loaded and compiled everything.

A node starts in a tenth of a second so, instead of in seconds: that is what makes hundreds of
restarts affordable. The process that forks has no threads and no ROS of its own, as it must not.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import Any

from microgripper_control.control.controller import Mode
from microgripper_control.control.feedforward import InverseKind
from microgripper_control.control.limits import VoltageLimits
from microgripper_control.control.tuning import default_gains
from microgripper_control.nodes.controller_settings import ControllerSettings, load_identified
from microgripper_control.nodes.parameters import MODEL_FILE
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.rig import Rig

NODES = ("plant_simulator", "controller", "reference", "recorder")
PERIOD = 1e-3  # s, of a sample
POLL = 0.002  # s
PR_SET_PDEATHSIG = 1  # of prctl: which signal the death of the parent sends
Place = Callable[[], None]  # what a child does first, to enter a host


class Child:
    """A forked process."""

    def __init__(self, name: str, pid: int, log: Path) -> None:
        self.name = name
        self.pid = pid
        self.log = log
        self._status: int | None = None

    @property
    def status(self) -> int | None:
        """Exit status, negative for the signal that killed it; None while it runs."""
        if self._status is None:
            pid, code = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self._status = os.waitstatus_to_exitcode(code)
        return self._status

    def send(self, number: signal.Signals) -> None:
        """Send a signal, if it runs."""
        if self.status is None:
            os.kill(self.pid, number)

    def wait(self, timeout: float) -> int | None:
        """Its exit status once it has ended; None if it does not in time, s."""
        end = time.monotonic() + timeout
        while self.status is None and time.monotonic() < end:
            time.sleep(POLL)
        return self.status

    def kill(self) -> None:
        """End it, whatever it does."""
        self.send(signal.SIGKILL)
        self.wait(10.0)

    @property
    def waited(self) -> float:
        """Time for which it has wanted a processor and got none, s."""
        return int(Path(f"/proc/{self.pid}/schedstat").read_text().split()[1]) * 1e-9

    @property
    def memory(self) -> int:
        """Resident memory, bytes."""
        pages = int(Path(f"/proc/{self.pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")


class Nursery:
    """All processes of a run; leaving the context leaves none of them behind."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._children: list[Child] = []
        self._count = 0

    def __enter__(self) -> Nursery:
        self._folder.mkdir(parents=True, exist_ok=True)
        _load()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for child in self._children:
            child.kill()

    def node(
        self,
        name: str,
        *,
        place: Place | None = None,
        **parameters: Any,  # noqa: ANN401
    ) -> Child:
        """Start a node with its parameters."""
        words = [word for pair in parameters.items() for word in ("-p", "{}:={}".format(*pair))]
        module = import_module(f"microgripper_control.nodes.{name}")

        def run() -> None:
            sys.argv = [name, *(["--ros-args", *words] if words else [])]
            module.main()

        return self.fork(name, run, place=place)

    def fork(self, name: str, run: Callable[[], object], *, place: Place | None = None) -> Child:
        """Run a function in a process of its own."""
        self._count += 1
        log = self._folder / f"{self._count:04d}_{name}.log"
        sys.stdout.flush()
        pid = os.fork()
        if pid == 0:
            os._exit(_live(run, log, place))
        child = Child(name, pid, log)
        self._children.append(child)
        return child


def _live(run: Callable[[], object], log: Path, place: Place | None) -> int:
    """What a child does all its life; its exit status."""
    with log.open("wb") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)  # as a program finds them
    os.setpgid(0, 0)  # Ctrl-C reaches who forked it alone,
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)  # whose death reaches all
    try:
        if place is not None:
            place()
        run()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except BaseException:
        traceback.print_exc()
        return 70
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return 0


def _load() -> None:
    """Import and compile all that the nodes need."""
    for name in NODES:
        import_module(f"microgripper_control.nodes.{name}")
    Rig(nominal_model(), PERIOD).tick()
    identified = load_identified(MODEL_FILE)
    ControllerSettings(
        Mode.CASCADE,
        InverseKind.EXACT,
        identified,
        VoltageLimits(),
        default_gains(identified, PERIOD),
        PERIOD,
    ).compile()
    gc.collect()
    gc.freeze()
