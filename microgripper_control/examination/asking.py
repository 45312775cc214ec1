"""Asks the diagnosis about one case, in a process of its own that gets files and nothing else."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microgripper_control.core.files import make_folder
from microgripper_control.validation.case_files import JOB

ANSWERED, FAILED, LATE, UNMADE = "answered", "failed", "too late", "not made"
LIMIT = 300.0  # s, for one diagnosis
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


def ask(case: Path, answer: Path, withheld: tuple[str, ...] = (), limit: float = LIMIT) -> Asked:
    """Run `microgripper diagnose` on the recordings in the folder `case`, writing into `answer`.

    `withheld` are effects to be left out of its library. An error, and no answer within `limit`
    seconds, are outcomes, too.
    """
    job = json.loads((case / JOB).read_text(encoding="utf-8"))
    words = [
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
            timeout=limit,
            start_new_session=True,  # Ctrl-C stops the examination, not an answer half way
            check=False,
        )
    except subprocess.TimeoutExpired:
        spent = time.perf_counter() - begun
        return Asked(LATE, spent, _busy() - busy, f"no answer within {limit:g} s")
    seconds, busy = time.perf_counter() - begun, _busy() - busy
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
