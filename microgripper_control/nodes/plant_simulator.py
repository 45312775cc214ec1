"""The simulated rig as a node.

In wall time tick k is due at start + k T, whatever happened before; when ticks were slept through
the plant moves on under the held voltage, and their samples are counted as missed, not published.
In lockstep tick k+1 follows as soon as the command that answers tick k has come; stamps count from
zero, and `/clock` tells the time. An answer that does not come ends the run with an error.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.core.parameters import Parameter
from microgripper_control.effects.registry import link_named
from microgripper_control.nodes import topics
from microgripper_control.nodes.health import Health, Level
from microgripper_control.nodes.managed import ManagedShell
from microgripper_control.nodes.pacing import Pace
from microgripper_control.nodes.parameters import (
    MODEL_FILE,
    MODEL_FILE_TEXT,
    declare_flag,
    declare_number,
    declare_numbers,
    declare_text,
    declare_texts,
    model_path,
)
from microgripper_control.nodes.shell import POLL, run
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model
from microgripper_control.plant.rig import Rig

PARAMETERS = (
    Parameter("sample_rate", "Hz", 1000.0, 0.1, 20000.0, "samples a second"),
    Parameter("duration", "s", 0.0, 0.0, 1e7, "end after so much of its own time; 0: never"),
    Parameter("startup_timeout", "s", 60.0, 0.1, 3600.0, "lockstep: longest wait for partners"),
    Parameter("lockstep_timeout", "s", 5.0, 0.01, 3600.0, "lockstep: longest wait for a command"),
)
NOISE = link_named("sensor_noise")
WORST_MISSED = 1e-3  # share of the ticks; more is a warning


class PlantSimulator(ManagedShell):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("plant_simulator")
        name = declare_text(self, "model_file", MODEL_FILE, MODEL_FILE_TEXT)
        declare_flag(self, "lockstep", False, "wait for the command that answers each sample")
        declare_texts(
            self,
            "partners",
            ["controller", "reference"],
            "lockstep: names of the nodes that must get joint_states before it begins",
        )
        declare_numbers(self, PARAMETERS)
        settings = load_model(model_path(name)).settings.get(NOISE.name, {})
        for name, key in (("noise_std", "std"), ("seed", "seed")):
            declared = NOISE.parameter(key)
            nominal = settings[key].value if key in settings else declared.nominal
            declare_number(self, replace(declared, name=name, nominal=nominal))

    def configure(self) -> None:
        """Load the model, compile, then offer the topics."""
        model = self._model()
        self._rate = float(self._value("sample_rate"))
        Rig(model, 1.0 / self._rate).tick()  # compiles; the one that runs draws its noise afresh
        self._rig = Rig(model, 1.0 / self._rate)
        self._tick = 0  # the next one
        self._last_tick = round(self._value("duration") * self._rate)
        self._missed = 0
        self._counted = (0, 0, 0, 0)
        self._state = JointState(name=[topics.JOINT], position=[0.0], velocity=[0.0], effort=[0.0])
        self._displacement, self._now = Float64(), Clock()
        self._states = topics.publish_on(self, topics.JOINT_STATES)
        self._displacements = topics.publish_on(self, topics.DISPLACEMENT)
        self._clock_publisher = self.create_publisher(Clock, "/clock", topics.quality(1))
        self._commands = topics.Newest(self, topics.VOLTAGE_COMMAND, self._on_command)

    def activate(self) -> None:
        """Go on from the tick that comes next."""
        self._lockstep = bool(self._value("lockstep"))
        # Waiting, in lockstep, for partners and then for the answer; in wall time for nothing.
        self._since = self._began = time.monotonic()
        self._asked = False
        self._origin = 0  # stamp of tick 0, ns
        if not self._lockstep:
            self._commands.open()
            self._origin = self.get_clock().now().nanoseconds - self._age(self._tick)
            self._pace = Pace(1.0 / self._rate, self._since)

    def deactivate(self) -> None:
        """Take no more commands; the voltage stays as it is."""
        self._commands.close()

    def cleanup(self) -> None:
        """Withdraw the topics."""
        for publisher in (self._states, self._displacements, self._clock_publisher):
            self.destroy_publisher(publisher)

    def work(self, now: float) -> float:
        """As `Shell` says."""
        if not self.active:
            return POLL
        if self._lockstep:
            self._check_partners(now)
            return POLL
        due = self._pace.due(now)
        for _ in range(due - 1):
            self._advance()
        if due:
            self._missed += due - 1
            self._advance()
            self._publish()
            self._finish_if_over()
        return self._pace.wait(time.monotonic())

    def _check_partners(self, now: float) -> None:
        waited = now - self._since
        if self._asked:
            if waited > self._value("lockstep_timeout"):
                self.fail(f"lockstep: no voltage_command for sample {self._tick - 1} in {waited:.3g} s")
            return
        self._commands.open(if_published=True)
        missing = topics.missing_partners(self, self._states, self._value("partners"))
        if not self._commands.is_open:
            missing = [*missing, f"a publisher of {topics.VOLTAGE_COMMAND}"]
        if not missing:
            self._ask()
        elif waited > self._value("startup_timeout"):
            self.fail(f"lockstep: {', '.join(missing)} not ready after {waited:.3g} s")

    def _ask(self) -> None:
        """Publish a sample that wants an answer."""
        self._advance()
        if not self._asked:
            self._asked, self._began = True, time.monotonic()
        self._since = time.monotonic()
        self._publish()

    def _on_command(self, message: Float64) -> None:
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
        """The newest sample; the messages are made once and sent over and over."""
        seconds, nanoseconds = divmod(self._origin + self._age(self._tick - 1), 10**9)
        rig, state = self._rig, self._state
        stamp = state.header.stamp
        stamp.sec, stamp.nanosec = seconds, nanoseconds
        if self._lockstep:
            self._now.clock = stamp
            self._clock_publisher.publish(self._now)
        state.position[0], state.velocity[0] = rig.position, rig.velocity
        state.effort[0] = rig.voltage
        self._states.publish(state)
        self._displacement.data = rig.position
        self._displacements.publish(self._displacement)

    def _age(self, tick: int) -> int:
        """When a tick is after tick 0, ns."""
        return round(tick * 1e9 / self._rate)

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        if not self.active:
            return Health("not active")
        rig = self._rig
        counts = (self._tick, self._missed, rig.clipped, rig.refused)
        ticks, missed, clipped, refused = (
            new - old for new, old in zip(counts, self._counted, strict=True)
        )
        self._counted = counts
        values = {
            "clock": "lockstep" if self._lockstep else "wall",
            "rate, Hz": (ticks - missed) / elapsed,
            "samples": self._tick - self._missed,
            "missed ticks": self._missed,
            "commands out of range": rig.clipped,
            "commands not finite": rig.refused,
        }
        if refused or clipped:
            return Health("voltage commands refused or out of range", Level.WARN, values)
        if missed > WORST_MISSED * ticks:
            return Health("ticks missed: the machine is too slow", Level.WARN, values)
        return Health(values=values)

    def _model(self) -> Model:
        noise = {"std": self._value("noise_std"), "seed": self._value("seed")}
        return load_model(model_path(self._value("model_file"))).with_link(NOISE.name, **noise)

    def _value(self, name: str) -> Any:  # noqa: ANN401 (of any type)
        return self.get_parameter(name).value


def main() -> None:
    """Run the node."""
    run(PlantSimulator)


if __name__ == "__main__":
    main()
