"""How far the gap shrinks, with an interval from a bootstrap over blocks of time.

Neighbouring samples share their error, so whole blocks are drawn, the same ones for both models
(Kunsch 1989; paired, because both were judged on the same data).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.noise import removable

BLOCKS = 40  # of all judging samples together
DRAWS = 1000
SEED = 20260101
LEVEL = 0.95
HELD = 0.1  # of the gap's power: a draw that holds less has nothing to close


def closed_fraction(refit: float, augmented: float, floor: float) -> float:
    """1 - e(augmented)/e(refit); 0 where there was nothing to close. All in m."""
    gap = removable(refit, floor)
    return 1.0 - removable(augmented, floor) / gap if gap > 0.0 else 0.0


def closed_interval(
    refit: Sequence[Array], augmented: Sequence[Array], floor: float
) -> tuple[float, float]:
    """The 95 % interval of the closed fraction, from errors, m, sample by sample."""
    before, after, counts = _blocks(refit), _blocks(augmented), _blocks(refit, squared=False)
    rng = np.random.default_rng(SEED)
    drawn = rng.integers(0, len(before), (DRAWS, len(before)))
    total = counts[drawn].sum(axis=1)
    least = HELD * removable(float(np.sqrt(before.sum() / counts.sum())), floor) ** 2
    values = [
        closed_fraction(float(np.sqrt(b)), float(np.sqrt(a)), floor)
        for b, a in zip(
            before[drawn].sum(axis=1) / total, after[drawn].sum(axis=1) / total, strict=True
        )
        if b - floor**2 >= least or least == 0.0
    ]
    low, high = np.quantile(values, [(1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0])
    return float(low), float(high)


def _blocks(errors: Sequence[Array], squared: bool = True) -> Array:
    """Sum of squares, or number of samples, of each block."""
    total = sum(len(error) for error in errors)
    sums: list[float] = []
    for error in errors:
        pieces = max(1, round(BLOCKS * len(error) / total))
        sums += [float(p @ p) if squared else float(len(p)) for p in np.array_split(error, pieces)]
    return np.array(sums)
