"""A diagnosis in a process of its own: the `microgripper diagnose` command, on one core.

It has the lowest priority, so that it takes only the time that the loop leaves. All of it is one
process: with it everything ends.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.diagnosis.result_file import RESULT

LOG = "diagnosis.log"  # what the command prints
LOWEST_PRIORITY = 19
PATIENCE = 2.0  # s, for a process to end when asked
ONE_CORE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


class DiagnosisJob:
    """A diagnosis that runs; its files go into the folder `out`, which is there."""

    def __init__(self, model_file: Path, recording: Path, out: Path) -> None:
        self._out = out
        self._began = time.monotonic()
        self._log = out / LOG
        command = [sys.executable, "-m", "microgripper_control", "diagnose", str(recording)]
        command += ["--model", str(model_file), "--out", str(out), "--jobs", "1"]
        try:
            with self._log.open("wb") as log:
                self._process = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    env=os.environ | ONE_CORE,
                )
        except OSError as error:
            raise MicrogripperError(f"{self._log}: cannot be written: {error.strerror}") from None
        os.setpriority(os.PRIO_PROCESS, self._process.pid, LOWEST_PRIORITY)

    @property
    def is_over(self) -> bool:
        """Whether it has ended."""
        return self._process.poll() is not None

    @property
    def running(self) -> float:
        """For how long, s."""
        return time.monotonic() - self._began

    def finding(self) -> str:
        """Its sentence, once it is over; MicrogripperError with the reason where it has failed."""
        status = self._process.wait()
        if status:
            said = self._log.read_text(encoding="utf-8", errors="replace").split("\n")
            said = [line.strip() for line in said if line.strip()]
            raise MicrogripperError(said[-1] if said else f"it ended with status {status}")
        content = json.loads((self._out / RESULT).read_text(encoding="utf-8"))
        return str(content["sentence"])

    def end(self) -> None:
        """End it now, if it runs."""
        self._process.terminate()
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
