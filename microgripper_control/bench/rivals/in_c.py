"""The nominal chain hand-written in C, compiled on the spot."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array

SOURCE = Path(__file__).with_name("chain.c")
OPTIONS = ("-O3", "-shared", "-fPIC")
NUMBERS = ctypes.POINTER(ctypes.c_double)


def compiler() -> str | None:
    """The C compiler of this machine, `CC` if that is set; None if there is none."""
    return shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc")


class ChainInC:
    """The nominal chain for one time grid; compiled into `folder` with `compiler()`.

    `parameters` are d, alpha d, beta, gamma; `step` the mechanics, shape (5,).
    """

    def __init__(
        self, folder: Path, cc: str, parameters: Array, step: Array, options: tuple[str, ...] = ()
    ) -> None:
        library = folder / f"chain{''.join(options)}.so"
        command = [cc, *OPTIONS, *options, "-o", str(library), str(SOURCE), "-lm"]
        try:
            subprocess.run(command, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError) as error:
            raise MicrogripperError(
                f"bench: {cc} does not compile {SOURCE.name}: {error}"
            ) from None
        self._chain = ctypes.CDLL(str(library)).chain
        self._chain.argtypes = [NUMBERS] * 4 + [ctypes.c_size_t]
        self._chain.restype = None
        self._given = [np.ascontiguousarray(part, dtype=float) for part in (parameters, step)]

    def simulate(self, voltage: Array, displacement: Array) -> None:
        """Fill in the displacement, m, shape (n,), for a voltage, V, held from sample to sample.

        The caller keeps the memory: pages that the system gives out anew would cost more than the
        arithmetic.
        """
        blocks = (*self._given, voltage, displacement)
        self._chain(*(block.ctypes.data_as(NUMBERS) for block in blocks), len(voltage))
