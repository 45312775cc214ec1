"""Samples in a row at which something is so."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def runs(mask: NDArray[np.bool_], shortest: int = 1) -> list[slice]:
    """The stretches in which a mask, shape (n,), is true for at least `shortest` samples."""
    edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    return [slice(int(a), int(b)) for a, b in edges if b - a >= shortest]
