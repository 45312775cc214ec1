"""How far back a force remembers the way, whether a rest leaves it that, and what it is called.

Friction sticks over a small part of the stroke and then slides; a force with hysteresis bends over
a good part of it. Either law can imitate the other: what they are called is a matter of size.
"""

import math

from microgripper_control.core.parameters import Parameter
from microgripper_control.effects.base import Scales, Values

# What sticks may creep or be shaken loose while a rig waits: then it begins from nothing.
RELEASED = Parameter(
    "released", "1", 0.0, 0.0, 1.0, "1 if it has let go before a recording begins", fitted=False
)
SHORT = 0.08  # of the stroke: the presliding of guides and joints is shorter


def released(values: Values) -> float:
    """Whether it has let go, before a recording begins, what the way there had made of it."""
    return values[RELEASED.name]


def unusually_long(memory: float, scales: Scales) -> float:
    """How far a way, m, is too long for friction: 0 where it is short, 1 at twice that."""
    return min(1.0, max(0.0, _octaves_beyond_short(memory, scales)))


def unusually_short(memory: float, scales: Scales) -> float:
    """How far a way, m, is too short for hysteresis: 1 at half of what is short, and below."""
    return min(1.0, max(0.0, -_octaves_beyond_short(memory, scales)))


def _octaves_beyond_short(memory: float, scales: Scales) -> float:
    if memory <= 0.0 or scales.stroke <= 0.0:
        return 0.0
    return math.log2(memory / (SHORT * scales.stroke))
