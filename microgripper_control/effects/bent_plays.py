"""Plays whose edges bend: Prandtl and Ishlinskii's loop, generalised.

    y_i is never below rise(u) - t_i, nor above fall(u) + t_i,      t_i = widest (i - 1/2) / N
    rise(u) = u + (rise_bow + (rise_skew + rise_curl p^2) p) (1 - p^2),     fall(u) likewise,
    p from 1 at `lowest` to -1 at `highest`
    what the plays lag behind:  sum_i s_i (y_i - u) / sum_i s_i,    s_i = e^(-taper (i - 1/2) / N)

or, where they are `relative`, behind as many whose edges are both the mean of the two: such a loop
is lopsided and nothing else.

Source: Al Janaideh, Rakheja, Su 2011 (a generalised play with unlike envelopes); Brokate, Sprekels
1996, section 2.3.
"""

import numpy as np

from microgripper_control.core.compiled import compiled, inlined
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Values

PLAYS = 8  # N
PLACES = (np.arange(PLAYS) + 0.5) / PLAYS
RISE = ("rise_bow", "rise_skew", "rise_curl")
FALL = ("fall_bow", "fall_skew", "fall_curl")
SHAPE = (*RISE, *FALL, "lowest", "highest", "relative")
ACROSS = np.linspace(-1.0, 1.0, 41)  # p
STATES = 2 * PLAYS  # the plays, then those with the mean edges


def thresholds(values: Values) -> Array:
    """t_i, V, shape (PLAYS,)."""
    return np.asarray(values["widest"] * PLACES)


def shares(values: Values) -> Array:
    """s_i / sum_i s_i, shape (PLAYS,)."""
    weights = np.exp(-values["taper"] * PLACES)
    return np.asarray(weights / np.sum(weights))


def edges(values: Values) -> Array:
    """What `move_bent_plays` goes by: the nine of `SHAPE`, the thresholds, V, and the shares."""
    shape = [values[name] for name in SHAPE]
    return np.concatenate([shape, thresholds(values), shares(values)])


def crossing(values: Values) -> float:
    """How far the edges are apart at most, as a share of what parts the plays on average.

    Where one edge has crossed the other by more than that, a play follows one of them, both ways:
    a bent line is left and no loop.
    """
    bow, skew, curl = (values[fall] - values[rise] for rise, fall in zip(RISE, FALL, strict=True))
    apart = max(abs(bend(bow, skew, curl, p)) for p in ACROSS)
    return apart / (2.0 * float(thresholds(values) @ shares(values)))


@inlined
def bend(bow: float, skew: float, curl: float, p: float) -> float:
    """How far an edge is above u, V."""
    return (bow + (skew + curl * (p * p)) * p) * (1.0 - p * p)


@compiled
def move_bent_plays(y: Array, u: float, edge: Array) -> float:
    """Move the plays y, shape (STATES,), to u, and how far they are then behind on average, V."""
    low, high = edge[6], edge[7]
    p = max(-1.0, min(1.0, (low + high - 2.0 * u) / (high - low))) if high > low else 1.0
    rise = u + bend(edge[0], edge[1], edge[2], p)
    fall = u + bend(edge[3], edge[4], edge[5], p)
    mean = 0.5 * (rise + fall)
    relative = edge[8] != 0.0
    behind = 0.0
    for i in range(PLAYS):
        threshold, other = edge[len(SHAPE) + i], u
        y[i] = max(rise - threshold, min(fall + threshold, y[i]))
        if relative:
            other = max(mean - threshold, min(mean + threshold, y[PLAYS + i]))
            y[PLAYS + i] = other
        behind += edge[len(SHAPE) + PLAYS + i] * (y[i] - other)
    return behind
