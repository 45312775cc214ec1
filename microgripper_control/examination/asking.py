"""Asks the diagnosis about one case, in a process of its own that gets files and nothing else."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microgripper_control.core.files import make_folder
from microgripper_control.validation.case_files import JOB

ANSWERED, FAILED, LATE, UNMADE = "answered", "failed", "too late", "not made"
LIMIT = 300  # s of processor time, for one diagnosis: beside other work it is not less
PATIENCE = 10  # times that by the clock, for a process that waits or that hardly gets a turn
LIMITED = 'ulimit -c 0; ulimit -S -t "$0"; exec "$@"'  # SIGXCPU ends what has used so many seconds
LAST_WORDS = 300  # characters of an error message that are kept


@dataclass(frozen=True)
class Asked:
    """What came back: one of the outcomes, why there is no answer, and `diagnosis.json`.

    `seconds` is the time by the clock, `busy` that of the processor.
    """

    outcome: str
    seconds: float
    busy: float
    why: str = ""
    diagnosis: dict[str, Any] | None = None


def ask(case: Path, answer: Path, withheld: tuple[str, ...] = (), limit: int = LIMIT) -> Asked:
    """Run `microgripper diagnose` on the recordings in the folder `case`, writing into `answer`.

    `withheld` are effects to be left out of its library. An error, and no answer within `limit`
    seconds of processor time, are outcomes, too. The limit is one process's: with one job there is
    no other.
    """
    job = json.loads((case / JOB).read_text(encoding="utf-8"))
    words = [
        *("/bin/sh", "-c", LIMITED, str(limit)),
        *(sys.executable, "-m", "microgripper_control", "diagnose"),
        *job["recordings"],
        *("--heldout", *job["heldout"], "--model", job["model"], "--hold", job["hold"]),
        *("--jobs", "1", "--out", str(make_folder(answer).resolve())),
        *(word for effect in withheld for word in ("--without", effect)),
    ]
    begun, busy = time.perf_counter(), _busy()
    try:
        ran = subprocess.run(
            words,
            cwd=case,
            env=_environment(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE * limit,
            start_new_session=True,  # Ctrl-C stops the examination, not an answer half way
            check=False,
        )
    except subprocess.TimeoutExpired:
        spent = time.perf_counter() - begun
        why = f"no answer within {PATIENCE * limit} s by the clock"
        return Asked(LATE, spent, _busy() - busy, why)
    seconds, busy = time.perf_counter() - begun, _busy() - busy
    if ran.returncode == -signal.SIGXCPU:
        return Asked(LATE, seconds, busy, f"no answer within {limit} s of a processor")
    found = answer / "diagnosis.json"
    if ran.returncode != 0 or not found.exists():
        last = ran.stderr.strip().rsplit("\n", 1)[-1][:LAST_WORDS]
        return Asked(FAILED, seconds, busy, f"exit status {ran.returncode}: {last}")
    return Asked(ANSWERED, seconds, busy, "", json.loads(found.read_text(encoding="utf-8")))


def _busy() -> float:
    """Processor time, s, of all processes that this one has started and seen end."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _environment() -> dict[str, str]:
    """One thread a process: several cases are at work at once."""
    package = str(Path(__file__).resolve().parents[2])
    before = os.environ.get("PYTHONPATH")
    return {
        **os.environ,
        "PYTHONPATH": f"{package}{os.pathsep}{before}" if before else package,
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "MKL_NUM_THREADS": "1",
    }
