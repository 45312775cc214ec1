"""Messages that nobody should send, from a seed."""

from __future__ import annotations

import math
import random

from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

WILD = (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, -0.0, 1e30, -1.0, 160.0, 1e-5)
NAMES: tuple[list[str], ...] = (
    [],
    ["finger"],
    ["finger"],
    ["finger"],
    ["thumb"],
    ["thumb", "finger"],
    [""],
    ["finger"] * 3,
)


class Hostile:
    """Draws them."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance

    def number(self) -> Float64:
        """A setpoint or a voltage."""
        return Float64(data=self._value())

    def sample(self) -> JointState:
        """Of joint_states: wrong names, arrays too short and too long, stamps of any time."""
        chance = self._chance
        message = JointState(
            name=list(chance.choice(NAMES)),
            position=[self._value() for _ in range(chance.choice((0, 1, 1, 1, 2, 5)))],
            effort=[self._value() for _ in range(chance.choice((0, 1, 1, 1, 2, 5)))],
        )
        message.header.stamp = Time(
            sec=chance.choice((0, -(2**31), 2**31 - 1, chance.randint(0, 2**31 - 1))),
            nanosec=chance.choice((0, 999_999_999, 2**32 - 1, chance.randint(0, 10**9 - 1))),
        )
        return message

    def _value(self) -> float:
        chance = self._chance
        kind = chance.random()
        if kind < 0.4:
            return chance.choice(WILD)
        if kind < 0.7:
            return chance.uniform(-1e-5, 3e-5)
        return chance.uniform(-50.0, 250.0)
