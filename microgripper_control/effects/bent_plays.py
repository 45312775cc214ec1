"""Plays whose edges bend: Prandtl and Ishlinskii's loop, generalised.

    y_i is never below rise(u) - t_i, nor above fall(u) + t_i,      t_i = widest (i - 1/2) / N
    rise(u) = u + (rise_bow + rise_skew (1 - 2 q)) 4 q (1 - q),     fall(u) likewise,
    q = (u - lowest) / (highest - lowest), from 0 to 1
    what the plays lag behind:  sum_i s_i (y_i - u) / sum_i s_i,    s_i = e^(-taper (i - 1/2) / N)

Source: Al Janaideh, Rakheja, Su 2011 (a generalised play with unlike envelopes); Brokate, Sprekels
1996, section 2.3.
"""

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Values

PLAYS = 8  # N
PLACES = (np.arange(PLAYS) + 0.5) / PLAYS
SHAPE = ("rise_bow", "rise_skew", "fall_bow", "fall_skew", "lowest", "highest")


def thresholds(values: Values) -> Array:
    """t_i, V, shape (PLAYS,)."""
    return np.asarray(values["widest"] * PLACES)


def edges(values: Values) -> Array:
    """What `move_bent_plays` goes by: the six of `SHAPE`, the thresholds, V, and the shares."""
    shares = np.exp(-values["taper"] * PLACES)
    shape = [values[name] for name in SHAPE]
    return np.concatenate([shape, thresholds(values), shares / np.sum(shares)])


@compiled
def move_bent_plays(y: Array, u: float, edge: Array) -> float:
    """Move the plays y, shape (PLAYS,), to u, and how far they are then from it on average, V."""
    low, high = edge[4], edge[5]
    q = min(1.0, max(0.0, (u - low) / (high - low))) if high > low else 0.0
    bow, skew = 4.0 * q * (1.0 - q), 1.0 - 2.0 * q
    rise = u + (edge[0] + edge[1] * skew) * bow
    fall = u + (edge[2] + edge[3] * skew) * bow
    behind = 0.0
    for i in range(PLAYS):
        threshold = edge[len(SHAPE) + i]
        y[i] = max(rise - threshold, min(fall + threshold, y[i]))
        behind += edge[len(SHAPE) + PLAYS + i] * (y[i] - u)
    return behind
