"""What the hysteresis tells of the time before a run."""

WAY = 5.0  # one over the alpha of a piezo is some 3 to 12


def gone_since_turn(h: float) -> float:
    """How far the free displacement has gone since it last turned, m, with its sign, from h, m.

    A loop of hysteresis opens by alpha of the way that is gone, as long as little of it is
    forgotten; h has the sign of that way.
    """
    return WAY * h
