"""Springs in parallel that slip one after the other: what remembers all turns of the way.

    force = sum_i k_i s_i,        s_i follows x, but never leaves -w_i .. w_i,        i = 0 .. N - 1
    w_i = widest 10^(-decades i / (N - 1)),        k_i = stiffness w_i^-taper / sum_j w_j^-taper

The distances at which they slip are spread over some decades; at none all slip at once. By taper
the short ones are the stiffer. Iwan's even distances (1966) are taper -1; Segalman (2005) finds
between -1 and 0 in bolted joints, and bearings have more: what slips first holds most.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from microgripper_control.core.compiled import inlined
from microgripper_control.core.signals import Array

SPRINGS = 16  # N; with half of them the corners of what slips bit by bit show, and trap a fit

SPREAD = ("distributed", "decades", "taper")  # the parameters of laws that have a part of it


def springs(widest: float, decades: float, taper: float) -> tuple[Array, Array]:
    """w_i, m, and k_i as shares of the whole stiffness, both of shape (N,)."""
    relative, shares = _spread(decades, taper)
    return widest * relative, shares


def all_slipped(decades: float, taper: float) -> float:
    """The force when all have slipped, over stiffness times widest."""
    limits, shares = springs(1.0, decades, taper)
    return float(limits @ shares)


@lru_cache(maxsize=64)
def _spread(decades: float, taper: float) -> tuple[Array, Array]:
    """w_i over the widest, and the shares: asked for several times whenever a chain is made."""
    relative = 10.0 ** -np.linspace(0.0, decades, SPRINGS)
    shares = relative**-taper
    shares /= np.sum(shares)
    relative.flags.writeable = shares.flags.writeable = False
    return relative, shares


@inlined
def pull(c: Array, first: int, before: Array, after: Array, at: int, way: float) -> float:
    """sum_i k_i s_i after a `way`, m, in one direction.

    `c` holds each w_i from `first` on and then each k_i, `before` and `after` s_i from `at` on.
    """
    force = 0.0
    for i in range(SPRINGS):
        limit = c[first + i]
        s = min(max(before[at + i] + way, -limit), limit)
        after[at + i] = s
        force += c[first + SPRINGS + i] * s
    return force
