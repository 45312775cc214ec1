"""Compilation of hot loops with numba, cached between processes.

numba keys its cache by the file of the compiled function alone: after an edit to a function it
calls, the caller would go on with the old numbers. The cache folder is therefore named after a
hash of every source that holds compiled code.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., object])

PACKAGE = Path(__file__).resolve().parents[1]
ROOMS_WITH_COMPILED_CODE = ("control", "core", "effects", "recordings")


def cache_folder() -> Path:
    """The folder for compiled code of exactly these sources and this numba."""
    digest = hashlib.sha256(numba.__version__.encode())
    for room in ROOMS_WITH_COMPILED_CODE:
        for source in sorted((PACKAGE / room).rglob("*.py")):
            digest.update(str(source.relative_to(PACKAGE)).encode())
            digest.update(source.read_bytes())
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "microgripper_control" / digest.hexdigest()[:16]


numba.config.CACHE_DIR = str(cache_folder())


def compiled(function: Function) -> Function:
    """Compile a module-level function to machine code (strict IEEE arithmetic, GIL released)."""
    return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy")(function))
