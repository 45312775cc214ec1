from __future__ import annotations

import numpy as np

from microgripper_control.control.limits import VoltageGuard, VoltageLimits
from microgripper_control.nodes.voltage_output import REPEATED, Descent

T = 1e-3


class Sent(list[float]):
    """Stands in for the output."""

    def send(self, guard: VoltageGuard) -> None:
        self.append(guard.voltage)


def descent(voltage: float) -> tuple[Descent, Sent]:
    guard, sent = VoltageGuard(VoltageLimits(), T), Sent()
    guard.start(voltage)
    return Descent(sent, guard, T), sent


def test_a_voltage_a_period_down_to_the_safe_one_which_is_repeated() -> None:
    way, sent = descent(10.0)
    now = 0.0
    while not way.is_over:
        wait = way.work(now)
        now += min(wait, T)
    assert sent == [8.0, 6.0, 4.0, 2.0, 0.0] + [0.0] * REPEATED


def test_what_was_slept_through_is_not_caught_up_on() -> None:
    way, sent = descent(100.0)
    times = np.array([0.0, 0.05, 0.0501, 0.0502, 0.0511])
    counts = []
    for now in times:
        way.work(now)
        counts.append(len(sent))
    assert counts == [1, 2, 2, 2, 3]
    assert sent == [98.0, 96.0, 94.0]
