"""What the hysteresis tells of the time before a run: on which way the rig came to where it rests.

A force or a play remembers that way, and nothing but h is left of it. So three pasts are thought
of: a first way from rest, and, in a rig that has been everywhere, a way up from the low end of the
drive and one down from the high end. Each would leave an h of its own; the h that was found speaks
for the two beside it, in proportion.
"""

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.signals import FALLEN, HIGH, LOW, RISEN, Array


@compiled
def shares_of_ways(h: float, first: float, risen: float, fallen: float) -> tuple[float, float]:
    """How far h, m, speaks for a way up and for one down, each 0 to 1, together at most 1.

    `first`, `risen`, `fallen`, m, are what h would be after each of the three ways; what is left of
    1 is for the first.
    """
    known = np.array([risen, fallen, first])
    lowest, middle, highest = np.argsort(known)
    if not known[highest] > known[lowest]:
        return 0.0, 0.0  # h tells nothing
    below, above = (lowest, middle) if h < known[middle] else (middle, highest)
    from_below = max(0.0, h - known[below])
    part = 1.0 if h >= known[above] else from_below / (known[above] - known[below])
    shares = np.zeros(3)
    shares[below] += 1.0 - part
    shares[above] += part
    return shares[0], shares[1]


def ways(levels: Array, row: int) -> list[tuple[float, tuple[float, ...]]]:
    """How far h speaks for each way that a signal may have come, and its turns and its end.

    `row` of the levels (shape (LEVELS,)) is where the signal rests.
    """
    end, low, high = (float(levels[place + row]) for place in (0, LOW, HIGH))
    risen, fallen = float(levels[RISEN]), float(levels[FALLEN])
    known = (
        (1.0 - risen - fallen, (end,)),
        (risen, (high, low, end)),
        (fallen, (low, high, end)),
    )
    return [(share, way) for share, way in known if share > 0.0]
