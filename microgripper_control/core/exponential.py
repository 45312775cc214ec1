"""An exponential growth that begins as x, and the way back from it; straight at a rate of zero."""

import math

from microgripper_control.core.compiled import compiled


@compiled
def grown(x: float, rate: float) -> float:
    """(e^(rate x) - 1) / rate."""
    return math.expm1(rate * x) / rate if rate != 0.0 else x


@compiled
def before_growth(y: float, rate: float) -> float:
    """The x that `grown` makes y of: ln(1 + rate y) / rate."""
    return math.log1p(rate * y) / rate if rate != 0.0 else y
