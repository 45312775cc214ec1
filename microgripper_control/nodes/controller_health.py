"""What the controller reports of itself."""

from __future__ import annotations

import math

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.nodes.health import Health, Level
from microgripper_control.nodes.pairing import Paired


class Statistics:
    """Counts since the controller became active; `since` the last report where it says so."""

    def __init__(self) -> None:
        self.late = 0  # setpoints that did not come in time
        self.unusable = 0  # samples without a finite displacement or voltage
        self._answered = 0
        self._last_setpoint = math.nan
        self._squares = 0.0  # m^2, since the last report
        self._compared = 0  # samples, since the last report
        self._before = (0, 0, 0)  # answered, unusable, refused and clamped, at the last report

    def note(self, paired: Paired) -> None:
        """Count a sample that was answered."""
        self._answered += 1
        if paired.setpoint is not None:
            self._last_setpoint = paired.setpoint
        error = self._last_setpoint - paired.displacement
        if math.isfinite(error):
            self._squares += error * error
            self._compared += 1

    def health(self, controller: Controller, elapsed: float) -> Health:
        """The report, `elapsed` s after the last one."""
        now = (self._answered, self.unusable, controller.refused + controller.clamped)
        answered, unusable, refused = (
            new - old for new, old in zip(now, self._before, strict=True)
        )
        self._before = now
        values: dict[str, object] = {
            "mode": controller.mode.value,
            "rate, Hz": answered / elapsed,
            "voltage, V": controller.guard.voltage,
            "answers": self._answered,
            "late setpoints": self.late,
            "unusable samples": self.unusable,
            "setpoints not finite": controller.refused,
            "setpoints out of reach": controller.clamped,
            "answers cut by the limits": controller.limited,
        }
        if self._compared and controller.mode is not Mode.OPEN_LOOP:
            values["tracking error rms, m"] = math.sqrt(self._squares / self._compared)
        self._squares, self._compared = 0.0, 0
        if not self._answered:
            return Health("waiting for joint_states", Level.OK, values)
        if not answered:
            return Health("no joint_states to answer", Level.WARN, values)
        if unusable:
            return Health("joint_states without a finite position and effort", Level.WARN, values)
        if refused:
            return Health("setpoints not finite or out of reach", Level.WARN, values)
        if math.isnan(self._last_setpoint):
            return Health("waiting for a setpoint", Level.OK, values)
        return Health(values=values)
