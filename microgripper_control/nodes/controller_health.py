"""What the controller reports of itself."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.nodes.exchange import Exchange
from microgripper_control.nodes.feedback_watch import Verdict
from microgripper_control.nodes.health import Health, Level
from microgripper_control.nodes.pairing import Paired
from microgripper_control.nodes.rivals import Rivals
from microgripper_control.nodes.setpoint_intake import SetpointIntake
from microgripper_control.nodes.topics import VOLTAGE_COMMAND

REFUSED = (Verdict.REPEATED, Verdict.LATE, Verdict.OUT_OF_TIME)


class Statistics:
    """Counts since the controller became active; what is compared is compared with the last report.

    `late` counts the setpoints that did not come in time.
    """

    def __init__(
        self, exchange: Exchange, intake: SetpointIntake, rivals: Mapping[str, Rivals]
    ) -> None:
        self.late = 0
        self._feedback, self._applied = exchange.feedback, exchange.applied
        self._stamps = exchange.stamps
        self._intake = intake
        self._rivals = rivals
        self._answered = 0
        self._last_setpoint = math.nan
        self._squares = 0.0  # m^2, since the last report
        self._compared = 0  # samples, since the last report
        self._before: dict[str, int] = {}

    def note(self, paired: Paired) -> None:
        """Count a sample that was answered."""
        self._answered += 1
        if paired.setpoint is not None and math.isfinite(paired.setpoint):  # else it was refused
            self._last_setpoint = paired.setpoint
        error = self._last_setpoint - paired.displacement
        if math.isfinite(error):
            self._squares += error * error
            self._compared += 1

    def forget_setpoint(self) -> None:
        """Compare with none until the next one comes: another mode may mean another unit."""
        self._last_setpoint = math.nan
        self._squares, self._compared = 0.0, 0

    def health(self, controller: Controller, elapsed: float, standing: str) -> Health:
        """The report, `elapsed` s after the last one; `standing` is wrong whatever happens."""
        counts = self._counts(controller)
        new = {name: count - self._before.get(name, 0) for name, count in counts.items()}
        self._before = counts
        per_sample = new["setpoints"] / max(new["answers"], 1)
        found = [
            one.state
            for topic, one in self._rivals.items()
            if one.look(time.monotonic(), 0.0 if topic == VOLTAGE_COMMAND else per_sample)
        ]
        values: dict[str, object] = {
            "mode": controller.mode.value,
            "rate, Hz": new["answers"] / elapsed,
            "rate by the stamps, Hz": self._stamps.told,
            "voltage, V": controller.guard.voltage,
            "feedback": self._feedback.state,
            "plant obeys": self._applied.state,
            "setpoints come as": self._intake.state,
            **{f"publishers of {topic}": one.state for topic, one in self._rivals.items()},
            **counts,
        }
        if self._compared and controller.mode is not Mode.OPEN_LOOP:
            values["tracking error rms, m"] = math.sqrt(self._squares / self._compared)
        self._squares, self._compared = 0.0, 0
        wrong = self._what_is_wrong(new) or next(iter(found), standing)
        if self._feedback.lost:
            return Health(f"feedback {self._feedback.state}; safe voltage", Level.ERROR, values)
        if wrong:
            return Health(wrong, Level.WARN, values)
        if not self._answered:
            return Health("waiting for joint_states", Level.OK, values)
        if math.isnan(self._last_setpoint):
            return Health("waiting for a setpoint", Level.OK, values)
        return Health(values=values)

    def _what_is_wrong(self, new: Mapping[str, int]) -> str:
        """The worst of what has happened since the last report; empty if nothing has."""
        if new["losses of feedback"]:
            return "feedback was lost, and came back"
        if new["times the plant did not obey"]:
            return "the plant does not apply voltage_command"
        if new["clock jumps"]:
            return "the plant's clock jumped"
        if new["unusable samples"]:
            return f"joint_states: {Verdict.UNUSABLE.value}"
        for verdict in REFUSED:
            if new[f"refused: {verdict.value}"]:
                return f"joint_states: {verdict.value}"
        if new["setpoints not finite or refused"] or new["setpoints out of reach"]:
            return "setpoints not finite or out of reach"
        if self._stamps.is_another:
            return "the plant's rate is not sample_rate: gains and margins are for another loop"
        if self._intake.stopped:
            return f"the stream of setpoints {self._intake.state}"
        return ""

    def _counts(self, controller: Controller) -> dict[str, int]:
        feedback = self._feedback
        return {
            "answers": self._answered,
            "setpoints": self._intake.count,
            "late setpoints": self.late,
            "setpoints not finite or refused": controller.refused,
            "setpoints out of reach": controller.clamped + self._intake.refused,
            "streams of setpoints stopped": self._intake.stops,
            "answers cut by the limits": controller.limited,
            "losses of feedback": feedback.losses,
            "times the plant did not obey": self._applied.refusals,
            "clock jumps": feedback.jumps,
            "samples missed": feedback.missed,
            "unusable samples": feedback.counts[Verdict.UNUSABLE],
            **{f"refused: {verdict.value}": feedback.counts[verdict] for verdict in REFUSED},
        }
