"""The plant simulator, noting when its samples go out and when they are answered.

For the benchmark: the node is the plant as it is. It gives the controller one setpoint, `setpoint`
m, so that there is something to work out, and writes the parameter `out` in the end.
"""

from __future__ import annotations

from std_msgs.msg import Float64

from microgripper_control.core.parameters import Parameter
from microgripper_control.nodes import topics
from microgripper_control.nodes.parameters import declare_number, declare_text
from microgripper_control.nodes.plant_simulator import PlantSimulator
from microgripper_control.nodes.round_trips import RoundTrips
from microgripper_control.nodes.shell import run

SETPOINT = Parameter("setpoint", "m", 8e-6, 0.0, 1e-3, "what the controller is asked for")


class TimedPlant(PlantSimulator):
    """See the module."""

    def __init__(self) -> None:
        super().__init__()
        self._trips = RoundTrips(declare_text(self, "out", "round_trips.json", "file to write"))
        self._setpoint = Float64(data=declare_number(self, SETPOINT))
        self._setpoints = topics.publish_on(self, topics.SETPOINT)

    def _publish(self) -> None:
        if self._tick == 1:
            self._setpoints.publish(self._setpoint)
        self._trips.sent()
        super()._publish()

    def _on_command(self, message: Float64) -> None:
        self._trips.answered()
        super()._on_command(message)

    def leave(self) -> None:
        """Keep what was noted."""
        super().leave()
        self._trips.write()


def main() -> None:
    """Run the node."""
    run(TimedPlant)


if __name__ == "__main__":
    main()
