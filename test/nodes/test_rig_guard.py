"""The rig's own guard, tick by tick."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from microgripper_control.control.limits import VoltageGuard, VoltageLimits
from microgripper_control.nodes.rig_guard import RigGuard

T = 1e-3
LIMIT = 0.06
RAMP = 2000.0 * T  # V a tick


class Driver:
    """A DAC with the guard in front of it."""

    def __init__(self, limit: float = LIMIT) -> None:
        self.guard = RigGuard(VoltageGuard(VoltageLimits(), T), limit, 0.0)
        self.voltage = self.command = 0.0
        self.tick = 0

    def run(self, ticks: int, command: float | None = None) -> np.ndarray:
        """The voltages of so many ticks, a command before each if one is given."""
        voltages = []
        for _ in range(ticks):
            self.tick += 1
            if command is not None and self.guard.command(command, self.tick * T):
                self.command = command if math.isfinite(command) else self.command
            guarded = self.guard.tick(self.tick * T, self.voltage)
            if guarded is not None:
                self.command = guarded
            self.voltage = self.command
            voltages.append(self.voltage)
        return np.array(voltages)


def obeying() -> Driver:
    """One whose commands have their way, at 100 V."""
    driver = Driver()
    begin = driver.run(60, 100.0)
    np.testing.assert_allclose(np.diff([0.0, *begin[:50]]), RAMP)
    assert set(begin[50:]) == {100.0}
    return driver


def test_once_it_has_caught_up_commands_have_their_way() -> None:
    driver = obeying()
    assert set(driver.run(10, 3.0)) == {3.0}
    assert not driver.guard.acting


def test_begun_again_it_catches_up_with_commands_as_at_first() -> None:
    """Of a rig that was put to rest and woken nobody knows what was sent to it meanwhile."""
    driver = obeying()
    driver.guard.release(driver.voltage)
    while driver.guard.acting and driver.voltage:
        driver.run(1)
    driver.guard.begin(driver.voltage)
    again = driver.run(60, 100.0)
    np.testing.assert_allclose(np.diff([0.0, *again[:50]]), RAMP)
    assert set(again[50:]) == {100.0}


def test_when_commands_stop_it_ramps_to_safe_and_back_once_they_come_again() -> None:
    driver = obeying()
    down = driver.run(200)
    held = np.count_nonzero(down == 100.0)
    assert held in (59, 60)
    np.testing.assert_allclose(np.diff(down[held - 1 : held + 50]), -RAMP)
    assert set(down[held + 50 :]) == {0.0}
    up = driver.run(60, 80.0)
    np.testing.assert_allclose(np.diff(up[:40]), RAMP)
    assert set(up[40:]) == {80.0}
    assert not driver.guard.acting
    assert set(driver.run(2, 20.0)) == {20.0}
    assert driver.guard.takeovers == 1


def test_after_the_rig_itself_stood_still_nothing_jumps() -> None:
    driver = obeying()
    driver.tick += 1000
    driver.guard.stood_still(1.0, driver.voltage)
    back = driver.run(60, 10.0)
    np.testing.assert_allclose(np.diff([100.0, *back[:45]]), -RAMP)
    assert back[-1] == 10.0


def test_what_is_not_finite_is_no_command() -> None:
    driver = obeying()
    assert driver.run(300, math.nan)[-1] == 0.0


def test_without_a_limit_and_without_any_command_it_does_nothing() -> None:
    driver = Driver(limit=0.0)
    driver.run(1, 100.0)
    assert set(driver.run(1000)) == {100.0}
    assert set(Driver().run(1000)) == {0.0}


def test_released_it_goes_down_whatever_was_commanded() -> None:
    driver = obeying()
    driver.guard.release(driver.voltage)
    assert driver.run(60)[-1] == 0.0


@given(
    st.lists(
        st.tuples(st.integers(1, 90), st.none() | st.floats(0.0, 160.0) | st.just(math.nan)),
        max_size=12,
    )
)
def test_from_a_takeover_until_it_has_caught_up_it_keeps_the_ramp_rate(
    script: list[tuple[int, float | None]],
) -> None:
    driver = Driver()
    for ticks, command in script:
        for _ in range(ticks):
            before, acting = driver.voltage, driver.guard.acting
            (voltage,) = driver.run(1, command)
            assert 0.0 <= voltage <= 160.0
            if acting:
                assert abs(voltage - before) <= RAMP + 1e-9
