"""All other methods on one case."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.examination.beside.black_box import shrink
from microgripper_control.examination.beside.evidence import Begun
from microgripper_control.examination.beside.grey_box import select
from microgripper_control.examination.beside.sparse import regress
from microgripper_control.examination.record import Beside

GREY_BOX, SPARSE, BLACK_BOX = "grey-box, BIC", "sparse regression", "Gaussian process"
METHODS = (GREY_BOX, SPARSE, BLACK_BOX)
FAULTS = (ArithmeticError, ValueError, np.linalg.LinAlgError, MicrogripperError)

Said = tuple[str | None, str | None, float]


def compare(case: Path, withheld: Sequence[str] = ()) -> dict[str, Beside]:
    """What each method says of the recordings in a case's folder."""
    started = time.process_time()
    try:
        begun = Begun.read(case)
    except FAULTS as error:
        spent = time.process_time() - started
        return {name: Beside(None, None, None, spent, str(error)) for name in METHODS}
    common = time.process_time() - started
    methods: dict[str, Callable[[], Said]] = {
        GREY_BOX: lambda: select(begun, withheld),
        SPARSE: lambda: regress(begun, withheld),
        BLACK_BOX: lambda: (None, None, shrink(begun)),
    }
    return {name: _one(method, common) for name, method in methods.items()}


def _one(method: Callable[[], Said], common: float) -> Beside:
    started = time.process_time()
    try:
        answer, stage, rmse = method()
        why = "" if np.isfinite(rmse) else "no finite error"
    except FAULTS as error:
        answer, stage, rmse, why = None, None, np.nan, str(error)
    seconds = common + time.process_time() - started
    return Beside(answer, stage, float(rmse) if np.isfinite(rmse) else None, seconds, why)
