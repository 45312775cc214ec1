"""What the hysteresis tells of the time before a run."""

import math

NEVER = -0.95  # of what h saturates at: closer to it the way would have no end


def gone_since_turn(h: float, alpha: float, per_way: tuple[float, float]) -> float:
    """How far the free displacement has gone since it last turned, m, with its sign, from h, m.

    It is taken to have turned at -h, as in a loop that is gone through over and over. A loop opens
    by `alpha` of the way; on the way to zero and on the way from there the share `per_way`, 1/m, of
    h is forgotten, so that the two parts are longer or shorter than |h| / alpha.
    """
    if alpha == 0.0:
        return 0.0
    back, on = (share * abs(h) / alpha for share in per_way)
    return h / alpha * (_stretched(back) + _stretched(-on))


def _stretched(x: float) -> float:
    """ln(1 + x) / x: how much longer a way to h is than without forgetting."""
    x = max(x, NEVER)
    return math.log1p(x) / x if x != 0.0 else 1.0
