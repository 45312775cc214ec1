"""What becomes of a setpoint on its way in, and of a stream of them that dies.

Setpoints set by hand come when they come. Those that come one after the other, none later than
`limit` after the last, are a stream; when it stops, the gripper may hold what it holds or return to
the safe voltage. The next setpoint ends that, by hand or not.
"""

from __future__ import annotations

import enum
import math

from microgripper_control.nodes.silence import Silence

STREAM = 20  # setpoints in a row make one


class OutOfReach(str, enum.Enum):
    """What to do with setpoints that cannot be reached."""

    CLAMP = "clamp"
    REFUSE = "refuse"


class StreamLoss(str, enum.Enum):
    """What to do when a stream of setpoints stops."""

    HOLD = "hold"
    RETURN = "return"


class SetpointIntake:
    """Counts what came, what was refused out of reach, and the streams that stopped."""

    def __init__(self, out_of_reach: OutOfReach, loss: StreamLoss, limit: float) -> None:
        self._out_of_reach = out_of_reach
        self._loss = loss
        self._silence = Silence(limit)
        self._in_row = 0
        self.stopped = False
        self.count = self.refused = self.stops = 0

    @property
    def returns(self) -> bool:
        """Whether the voltage is to go to the safe one."""
        return self.stopped and self._loss is StreamLoss.RETURN

    @property
    def state(self) -> str:
        """In words."""
        if self.stopped:
            return "stopped: " + ("returned to safe" if self.returns else "held")
        return "stream" if self._in_row >= STREAM else "by hand"

    @property
    def left(self) -> float:
        """Time until a stream has stopped if nothing comes, s."""
        return self._silence.left if self._in_row >= STREAM else math.inf

    def take(self, setpoint: float, reach: tuple[float, float], now: float) -> float:
        """The setpoint to go on with, one that came at `now`, s; NaN if it is refused.

        One that is refused, or not finite, is none: it neither ends a stop nor keeps a stream up.
        """
        self.count += 1
        inside = reach[0] <= setpoint <= reach[1]
        if not math.isfinite(setpoint):
            return math.nan
        if self._out_of_reach is OutOfReach.REFUSE and not inside:
            self.refused += 1
            return math.nan
        self._in_row = 1 if self._silence.is_over(now) else min(self._in_row + 1, STREAM)
        self._silence.heard(now)
        self.stopped = False
        return setpoint

    def look(self, now: float) -> None:
        """Notice at `now`, s, that a stream has stopped."""
        if self._silence.is_over(now) and self._in_row:
            self.stopped = self._in_row >= STREAM
            self.stops += self.stopped
            self._in_row = 0
