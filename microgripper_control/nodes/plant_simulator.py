"""The simulated rig as a node.

In wall time tick k is due at start + k T, whatever happened before; when ticks were slept through
the plant moves on under the held voltage, and their samples are counted as missed, not published.
In lockstep tick k+1 follows as soon as the command that answers tick k has come; stamps count from
zero, and `/clock` tells the time. An answer that does not come ends the run with an error, and so
does a second publisher: whatever it sends would pass for an answer.

As a rig's driver should, it does not rely on the controller: in wall time, when commands stop, it
brings the voltage down by itself, and on deactivation, too.
"""

from __future__ import annotations

import math
import time

from std_msgs.msg import Float64

from microgripper_control.nodes import plant_settings, topics
from microgripper_control.nodes.health import Health, Level
from microgripper_control.nodes.managed import ManagedShell
from microgripper_control.nodes.pacing import Pace
from microgripper_control.nodes.rivals import Rivals
from microgripper_control.nodes.sample_publisher import SamplePublisher
from microgripper_control.nodes.shell import POLL, run

WORST_MISSED = 1e-3  # share of the ticks; more is a warning


class PlantSimulator(ManagedShell):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("plant_simulator")
        plant_settings.declare(self)
        self._commands = topics.Newest(self, topics.VOLTAGE_COMMAND, self._on_command)
        self._rivals = Rivals(self, topics.VOLTAGE_COMMAND)

    def configure(self) -> None:
        """Load the model, compile, then offer the topics."""
        self._rig = plant_settings.make_rig(self)
        self._guard = plant_settings.make_guard(self, self._rig.voltage)
        self._rate: float = self.value_of("sample_rate")
        self._last_tick = round(self.value_of("duration") * self._rate)
        self._tick = 0  # the next one
        self._missed = self._commanded = 0
        self._counted: dict[str, int] = {}
        self._samples = SamplePublisher(self, 1.0 / self._rate)

    def activate(self) -> None:
        """Go on from the tick that comes next."""
        self._lockstep = self.value_of("lockstep")
        self._asked = False  # in lockstep, once the partners are there
        self._looked = -math.inf  # when it looked for a second publisher
        # Since when it has waited in lockstep, for the partners or the answer.
        self._since = self._began = time.monotonic()
        self._origin = 0  # stamp of tick 0, ns
        if not self._lockstep:
            self._guard.begin(self._rig.voltage)
            self._commands.open(reliable=False)
            self._origin = self.get_clock().now().nanoseconds - self._age(self._tick)
            self._pace = Pace(1.0 / self._rate, self._since)

    def deactivate(self) -> None:
        """Take no more commands, and bring the voltage down."""
        self._commands.close()
        if self._lockstep or self.outcome is not None:
            return
        self._guard.release(self._rig.voltage)
        while self._guard.acting and self._rig.voltage != self._guard.safe:
            time.sleep(self._pace.wait(time.monotonic()))
            self._pass(time.monotonic())

    def cleanup(self) -> None:
        """Withdraw the topics."""
        self._samples.close()

    def leave(self) -> None:
        """Stay until the last sample has arrived."""
        if self.outcome is not None and self.outcome.status == 0:
            topics.await_delivery([self._samples.states])
        super().leave()

    def work(self, now: float) -> float:
        """As `Shell` says."""
        if not self.active:
            return POLL
        if self._lockstep:
            self._check_lockstep(now)
            return POLL
        self._pass(now)
        self._finish_if_over()
        return self._pace.wait(time.monotonic())

    def _pass(self, now: float) -> None:
        """Let the ticks pass that have become due."""
        due = self._pace.due(now)
        if not due:
            return
        for _ in range(due - 1):
            self._rig.miss()
        self._missed += due - 1
        self._tick += due - 1
        self._guard.stood_still((due - 1) * self._pace.period, self._rig.voltage)
        guarded = self._guard.tick(now, self._rig.voltage)
        if guarded is not None:
            self._rig.command(guarded)
        self._advance()
        self._publish()

    def _check_lockstep(self, now: float) -> None:
        """Begin once everybody is there; fail where somebody is missing for too long."""
        waited = now - self._since
        if self._asked:
            self._refuse_rivals(now)
            if waited > self.value_of("lockstep_timeout"):
                sample = self._tick - 1
                self.fail(
                    f"lockstep: no voltage_command for sample {sample} in {waited:.3g} s; a run "
                    "that is to end by itself needs a duration"
                )
            return
        self._commands.open(if_published=True)
        missing = topics.missing_partners(self, self._samples.states, self.value_of("partners"))
        if not self._commands.is_open:
            missing.append("a publisher of voltage_command")
        if not missing:
            self._asked, self._began = True, now
            self._ask()
        elif waited > self.value_of("startup_timeout"):
            self.fail(f"lockstep: {', '.join(missing)} not ready after {waited:.3g} s")

    def _refuse_rivals(self, now: float) -> None:
        if now < self._looked + POLL:  # it takes longer than a sample
            return
        self._looked = now
        names = self._rivals.names()
        if len(names) > 1:
            self.fail(f"lockstep: voltage_command is published by {' and '.join(names)}, not one")

    def _ask(self) -> None:
        """Publish a sample that wants an answer."""
        self._advance()
        self._since = time.monotonic()
        self._publish()

    def _on_command(self, message: Float64) -> None:
        self._commanded += 1
        if self._lockstep or self._guard.command(message.data, time.monotonic()):
            self._rig.command(message.data)
        if self.active and self._lockstep and self._asked and self.outcome is None:
            self._finish_if_over()
            if self.outcome is None:
                self._ask()

    def _finish_if_over(self) -> None:
        if 0 < self._last_tick <= self._tick:
            took = time.monotonic() - self._began
            self.finish(f"{self._tick} samples in {took:.3f} s, {self._missed} of them missed")

    def _advance(self) -> None:
        self._rig.tick()
        self._tick += 1

    def _publish(self) -> None:
        stamp = self._origin + self._age(self._tick - 1)
        self._samples.publish(self._rig, stamp, tell_time=self._lockstep)

    def _age(self, tick: int) -> int:
        """When a tick is after tick 0, ns."""
        return round(tick * 1e9 / self._rate)

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        if not self.active:
            return Health("not active")
        new = self._new_counts()
        rivals = not self._lockstep and self._rivals.look(
            time.monotonic(), new["commands"] / max(new["samples"], 1)
        )
        values = {
            "clock": "lockstep" if self._lockstep else "wall",
            "rate, Hz": new["samples"] / elapsed,
            "voltage, V": self._rig.voltage,
            "rig's guard": "acting" if self._guard.acting else "ok",
            "publishers of voltage_command": self._rivals.state,
            **self._counted,
        }
        wrong = ""
        if self._guard.silent and self._guard.heard:
            wrong = "no voltage_command: the rig went to its safe voltage by itself"
        elif new["times the rig's guard took over"]:
            wrong = "the rig's guard took over for a while"
        elif rivals:
            wrong = f"voltage_command has {self._rivals.state}"
        elif new["commands not finite"] or new["commands out of range"]:
            wrong = "voltage commands refused or out of range"
        elif new["missed ticks"] > WORST_MISSED * (new["samples"] + new["missed ticks"]):
            wrong = "ticks missed: the machine is too slow"
        return Health(wrong, Level.WARN, values) if wrong else Health(values=values)

    def _new_counts(self) -> dict[str, int]:
        """What was counted since the last call."""
        counts = {
            "samples": self._tick - self._missed,
            "missed ticks": self._missed,
            "commands": self._commanded,
            "commands out of range": self._rig.clipped,
            "commands not finite": self._rig.refused,
            "times the rig's guard took over": self._guard.takeovers,
        }
        new = {name: count - self._counted.get(name, 0) for name, count in counts.items()}
        self._counted = counts
        return new


def main() -> None:
    """Run the node."""
    run(PlantSimulator)


if __name__ == "__main__":
    main()
