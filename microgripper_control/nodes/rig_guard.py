"""The rig's own guard: what the one who drives the DAC does when commands stop.

It does not rely on the controller, which may have died, nor on the network. When no command came
for `limit`, or the rig itself stood still for as long, it takes over: the voltage goes to the safe
one at the ramp rate, and from there, at the same rate, to the commands once they come again. When
it has caught up with them they have their way. In the beginning, too: nobody knows for how long
somebody has been sending to a rig that was not there.
"""

from __future__ import annotations

import math

from microgripper_control.control.limits import VoltageGuard
from microgripper_control.nodes.silence import Silence


class RigGuard:
    """Knows commands, ticks and a clock, s, and no ROS: a driver for a real DAQ can use it.

    `limit` is in s, 0 for never; `voltage`, V, is where the rig stands.
    """

    def __init__(self, guard: VoltageGuard, limit: float, voltage: float) -> None:
        self._guard = guard
        self._limit = limit
        self.takeovers = 0
        self.begin(voltage)

    def begin(self, voltage: float) -> None:
        """Begin, or begin again, at `voltage`, V, as if nothing had been commanded yet."""
        self._guard.start(voltage)
        self._silence = Silence(self._limit)
        self._command = self.safe
        self.acting = self._limit > 0.0
        self.heard = self.silent = False

    @property
    def safe(self) -> float:
        """Where it goes when commands stop, V."""
        return self._guard.limits.safe

    def command(self, voltage: float, now: float) -> bool:
        """Note a command, V; whether it goes to the rig now. One that is not finite is none."""
        if not math.isfinite(voltage):
            return True  # the rig refuses it, and counts it
        self._command = voltage
        self.heard = True
        self._silence.heard(now)
        return not self.acting

    def stood_still(self, length: float, voltage: float) -> None:
        """Say that the rig slept for `length`, s, under `voltage`, V: it takes over if long."""
        if length >= self._silence.limit:
            self._take_over(voltage)

    def release(self, voltage: float) -> None:
        """Take over from `voltage`, V, for good: the command is the safe voltage from here on."""
        self._command = self.safe
        self._take_over(voltage)

    def tick(self, now: float, voltage: float) -> float | None:
        """The voltage for this tick, V, after `voltage`; None where commands have their way."""
        self.silent = self._silence.is_over(now) or not self.heard
        if self.silent and self.heard and not self.acting:
            self._take_over(voltage)
        if not self.acting:
            return None
        goal = self.safe if self.silent else self._guard.limits.clip(self._command)
        answer = self._guard.ramp_to(goal)
        self.acting = self.silent or answer != goal
        return answer

    def _take_over(self, voltage: float) -> None:
        self.acting = True
        self.takeovers += 1
        self._guard.start(voltage)
