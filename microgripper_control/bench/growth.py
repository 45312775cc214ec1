"""How a cost grows with a size: the exponent of a power law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.bench.row import Goal, at_most
from microgripper_control.bench.timing import Spread
from microgripper_control.core.signals import Array

LINEAR: Goal = at_most(1.1)  # 1 is linear; the rest is what caches and noise may do


def exponent(sizes: Sequence[float], costs: Array) -> Spread:
    """p of cost ~ size^p by least squares, round by round; `costs` has shape (sizes, rounds)."""
    x = np.log(np.asarray(sizes, dtype=float))
    x -= x.mean()
    slopes = x @ np.log(costs) / (x @ x)
    return Spread.of(slopes)
