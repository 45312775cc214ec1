"""Runs an examination: each case is made, sealed, asked about, and looked at once more.

A case that has its result is not done again, so an examination that was stopped goes on.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder
from microgripper_control.core.folder_lock import FolderLock
from microgripper_control.diagnosis.search.schedule import side_by_side
from microgripper_control.examination.asking import LIMIT, UNMADE, ask
from microgripper_control.examination.beside.compare import compare
from microgripper_control.examination.equals import rivals_of
from microgripper_control.examination.folder import Folder, read_json, write_json
from microgripper_control.examination.plan import Planned
from microgripper_control.examination.record import Record
from microgripper_control.validation.case import Case, make_case
from microgripper_control.validation.case_files import write_case

AT_WORK = "another examination, or what is left of it, is at work here; wait for it or end it"

# done(number of cases with a result, all cases, s left or None)
OnProgress = Callable[[int, int, float | None], None]


def run(
    root: Path,
    planned: Sequence[Planned],
    progress: OnProgress,
    jobs: int = -1,
    limit: int = LIMIT,
    asked: Sequence[Planned] | None = None,
) -> list[Record]:
    """Do the cases that have no result yet, `jobs` at once; return all records in order.

    All that are planned, or those `asked` for; a later run may do more of them.

    `limit` is the processor time for one diagnosis, s. On a cluster every worker must see the
    folder `root`. MicrogripperError if it holds another examination, or one of other code.
    """
    folder = Folder(root.resolve())
    folder.begin(planned)
    asked = planned if asked is None else asked
    with closing(FolderLock(make_folder(folder.root / "results"), AT_WORK)):
        left = [one for one in asked if not folder.result(one).exists()]
        before, begun = len(asked) - len(left), time.monotonic()
        progress(before, len(asked), None)
        tasks = [(folder.root, one, limit) for one in left]
        for done, _ in enumerate(side_by_side(examine, tasks, jobs), start=1):
            each = (time.monotonic() - begun) / done
            progress(before + done, len(asked), each * (len(left) - done))
    return [Record.of(read_json(folder.result(one))) for one in asked]


def examine(root: Path, planned: Planned, limit: int) -> None:
    """Do one case and keep its result.

    A run that was killed may leave workers that still do some: none is done by two at once.
    """
    folder = Folder(root)
    with closing(FolderLock(make_folder(folder.answer(planned)), AT_WORK)):
        if not folder.result(planned).exists():
            _examine(folder, planned, limit)


def _examine(folder: Folder, planned: Planned, limit: int) -> None:
    begun = time.perf_counter()
    try:
        case = make_case(
            planned.question,
            planned.effects,
            planned.form,
            planned.strength,
            planned.excitation,
            planned.seed,
            planned.brief,
        )
    except (ArithmeticError, ValueError, np.linalg.LinAlgError, MicrogripperError) as error:
        write_json(folder.result(planned), Record(planned, UNMADE, str(error)).plain())
        return
    write_case(case, folder.case(planned), folder.seal(planned))
    making = time.perf_counter() - begun
    record = _asked(folder, planned, case, making, limit)
    folder.refuse_other_code()  # the diagnosing process has read them as they are now
    write_json(folder.result(planned), record.plain())


def _asked(folder: Folder, planned: Planned, case: Case, making: float, limit: int) -> Record:
    asked = ask(folder.case(planned), folder.answer(planned), planned.withheld, limit)
    begun = time.perf_counter()
    beside = compare(folder.case(planned), planned.withheld)
    compared = time.perf_counter()
    rivals = rivals_of(case, asked.diagnosis) if asked.diagnosis else {}
    seconds = {
        "making": making,
        "diagnosing": asked.seconds,
        "diagnosing_busy": asked.busy,
        "beside": compared - begun,
        "rivals": time.perf_counter() - compared,
    }
    return Record(planned, asked.outcome, asked.why, seconds, asked.diagnosis, beside, rivals)
