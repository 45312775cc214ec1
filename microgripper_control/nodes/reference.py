"""Publishes a setpoint for each sample of the plant, in answer to it.

Sample 0 is the first that comes once the partners get the setpoints; from there on the setpoint for
a sample follows from its stamp, so that samples which were lost delay nothing. A sample that was
overtaken, or whose stamp is wild, is answered with the setpoint that stands. Without samples there
is nothing to follow, and nothing is published. With `quantity: voltage` the setpoints are
volts and go to `voltage_setpoint`, for the controller's mode open_loop.
"""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.nodes import topics
from microgripper_control.nodes.controller_settings import SAMPLE_RATE
from microgripper_control.nodes.health import Health
from microgripper_control.nodes.pacing import SampleNumber
from microgripper_control.nodes.parameters import declare_number, declare_text, declare_texts
from microgripper_control.nodes.reference_settings import declare_course
from microgripper_control.nodes.shell import POLL, Shell, run

TOPICS = {"displacement": topics.SETPOINT, "voltage": topics.VOLTAGE_SETPOINT}
HOLD, STOP = "hold", "stop"
BLOCK = 4096  # samples worked out at a time


class Reference(Shell):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("reference")
        quantity = declare_text(
            self,
            "quantity",
            "displacement",
            "what the setpoints are: m, or V for open loop",
            choices=list(TOPICS),
            read_only=True,
        )
        self._at_end = declare_text(
            self,
            "at_end",
            HOLD,
            "hold the last setpoint, or stop the node",
            choices=(HOLD, STOP),
            read_only=True,
        )
        self._partners = declare_texts(
            self,
            "partners",
            ["controller"],
            "names of the nodes that must get the setpoints before they begin",
        )
        self._rate = declare_number(self, SAMPLE_RATE, read_only=True)
        self._course, self._length = declare_course(self, 1.0 / self._rate)
        self._block: list[float] = []
        self._block_start = 0
        self._number = SampleNumber(self._rate)
        self._setpoint = Float64(data=self._value_at(0))
        self._setpoints = topics.publish_on(self, TOPICS[quantity])
        self._samples = topics.Newest(self, topics.JOINT_STATES, self._on_sample)

    def work(self, now: float) -> float:
        """As `Shell` says."""
        if not self._samples.is_open and not self._missing():
            self._samples.open(if_published=True)
        return POLL

    def leave(self) -> None:
        """Stay until the last setpoint has arrived."""
        if self.outcome is not None:
            topics.await_delivery([self._setpoints])

    def _missing(self) -> list[str]:
        return topics.missing_partners(self, self._setpoints, self._partners)

    def _on_sample(self, message: JointState) -> None:
        sample = self._number.of(topics.stamp_of(message))
        self._setpoint.data = self._value_at(sample)
        self._setpoints.publish(self._setpoint)
        if self._at_end == STOP and self._length is not None and sample >= self._length - 1:
            self.finish(f"the last of {self._length} setpoints is out")

    def _value_at(self, sample: int) -> float:
        index = sample - self._block_start
        if not 0 <= index < len(self._block):
            self._block_start, index = sample, 0
            samples = np.arange(sample, sample + BLOCK)
            self._block = self._course.values(samples, 1.0 / self._rate).tolist()
        return self._block[index]

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        missing = [] if self._samples.is_open else self._missing()
        if missing:
            return Health("waiting for " + ", ".join(missing))
        values = {
            "samples answered": self._number.newest + 1,
            "samples in all": "endless" if self._length is None else self._length,
            "setpoint, m or V": self._setpoint.data,
        }
        if self._number.disbelieved:
            values["stamps from another time"] = self._number.disbelieved
        if self._number.restarts:
            values["times the plant's clock ran backwards"] = self._number.restarts
        return Health(
            "waiting for joint_states" if self._number.newest < 0 else "ok", values=values
        )


def main() -> None:
    """Run the node."""
    run(Reference)


if __name__ == "__main__":
    main()
