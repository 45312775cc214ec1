"""Compilation of hot loops with numba, cached between processes.

numba keys its cache by the file of the compiled function alone: after an edit to a function it
calls, the caller would go on with the old numbers. The cache folder is therefore named after a
hash of every source that holds compiled code.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

Function = TypeVar("Function", bound=Callable[..., object])

PACKAGE = Path(__file__).resolve().parents[1]
ROOMS_WITH_COMPILED_CODE = ("control", "core", "effects", "recordings", "validation")


def cache_folder() -> Path:
    """The folder for compiled code of exactly these sources and this numba.

    A service may have no home, or one that it cannot write: then it is a temporary folder.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for room in ROOMS_WITH_COMPILED_CODE:
        add_sources(digest, PACKAGE, room)
    name = digest.hexdigest()[:16]
    for home in _homes():
        if _can_be_written(home):
            return home / name
    return Path(tempfile.mkdtemp(prefix="microgripper_control-"))


def add_sources(digest: hashlib._Hash, root: Path, room: str = "") -> None:
    """Have a hash depend on every source in a room below `root`, and on where in there it lies."""
    for source in sorted((root / room).rglob("*.py")):
        digest.update(str(source.relative_to(root)).encode())
        digest.update(source.read_bytes())


def _homes() -> Iterator[Path]:
    """Where compiled code may lie: among the user's caches, or in a temporary folder of his own."""
    with suppress(RuntimeError):  # no home
        usual = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        yield usual / "microgripper_control"
    own = Path(tempfile.gettempdir()) / f"microgripper_control-{os.getuid()}"
    if not own.exists() or own.stat().st_uid == os.getuid():
        yield own


def _can_be_written(folder: Path) -> bool:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


numba.config.CACHE_DIR = str(cache_folder())

# IEEE arithmetic with the GIL released; a product and a sum may be rounded once instead of twice,
# which processors do in one step.
OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract"},
}


def compiled(function: Function) -> Function:
    """Compile a module-level function to machine code."""
    return cast(Function, numba.njit(**OPTIONS)(function))


def inlined(function: Function) -> Function:
    """As `compiled`, for a part of a hot loop: it is merged into the functions that call it."""
    return cast(Function, numba.njit(**OPTIONS, forceinline=True)(function))


@cache
def _entry(function: Callable[..., float], arrays: int, numbers: int) -> Any:  # noqa: ANN401
    block = types.CPointer(types.float64)
    signature = types.float64(*[block] * arrays, *[types.float64] * numbers)
    return numba.cfunc(signature, **OPTIONS)(function)


def address_of(function: Callable[..., float], arrays: int, numbers: int) -> float:
    """Where the machine code of a plain function of so many arrays, then numbers, lies.

    It is compiled on first use. A kernel reads the address among its coefficients and calls it by
    `call_at`, so that one compiled kernel serves functions it has never heard of. A number holds
    an address to the bit: addresses have 47 bits, numbers 53.
    """
    return float(_entry(function, arrays, numbers).address)


def _call_at(
    typing: object, address: object, arguments: types.BaseTuple
) -> tuple[object, Callable[..., object]]:
    """Call the function at an address with whole numbers as its arrays' addresses."""

    def emit(context: object, builder: ir.IRBuilder, signature: object, given: list[Any]) -> object:
        number = ir.DoubleType()
        values = []
        for index, kind in enumerate(arguments):
            value = builder.extract_value(given[1], index)
            if isinstance(kind, types.Integer):
                value = builder.inttoptr(value, number.as_pointer())
            values.append(value)
        function = ir.FunctionType(number, [value.type for value in values]).as_pointer()
        return builder.call(builder.inttoptr(given[0], function), values)

    return types.float64(types.int64, arguments), emit


# call_at(address, (array addresses ..., numbers ...)) -> number, in compiled code only
call_at = cast(Callable[[int, tuple[float, ...]], float], intrinsic(_call_at))
