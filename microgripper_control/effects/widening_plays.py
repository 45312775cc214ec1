"""Plays whose thresholds widen: Prandtl and Ishlinskii's loop, rate-dependent.

    y_i follows u, but is never further from it than t_i (1 + share),     t_i = widest i / N
    what the widening adds to the loop:  slope / N sum_i ((u - y_i) - (u - y_i at share 0))

Source: Al Janaideh, Rakheja, Su 2011, with thresholds that depend on the rate.
"""

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.signals import Array

PLAYS = 8  # N


def at_rest(u: float) -> Array:
    """The state where all plays have arrived, shape (2 N,): widened ones and the others."""
    return np.full(2 * PLAYS, u)


@compiled
def move_plays(y: Array, u: float, threshold: float, share: float) -> float:
    """Move the plays to u, the first threshold being as given; sum of what the widening adds, V."""
    added, factor = 0.0, max(0.0, 1.0 + share)
    for i in range(PLAYS):
        own = threshold * (i + 1)
        wide = own * factor
        y[i] = min(max(y[i], u - wide), u + wide)
        y[PLAYS + i] = min(max(y[PLAYS + i], u - own), u + own)
        added += y[PLAYS + i] - y[i]
    return added
