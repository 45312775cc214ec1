from __future__ import annotations

import math

import numpy as np
import pytest

from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.rig import Rig
from microgripper_control.plant.simulate import simulate

T = 0.001


def test_each_sample_answers_to_the_voltages_before_it() -> None:
    voltages = 80.0 - 80.0 * np.cos(2.0 * np.pi * np.arange(200) / 100.0)
    rig = Rig(nominal_model(), T)
    positions, velocities, applied = [], [], []
    for voltage in voltages:
        rig.command(voltage)
        rig.tick()
        positions.append(rig.position)
        velocities.append(rig.velocity)
        applied.append(rig.voltage)
    np.testing.assert_array_equal(applied, voltages)
    np.testing.assert_array_equal(positions, simulate(nominal_model(), voltages, T))
    np.testing.assert_allclose(velocities[1:], np.diff(positions) / T)
    assert velocities[0] == 0.0


def test_the_newest_command_is_held() -> None:
    rig = Rig(nominal_model(), T)
    rig.command(10.0)
    rig.command(20.0)
    for _ in range(3):
        rig.tick()
        assert rig.voltage == 20.0


def test_commands_beyond_the_range_are_clipped_and_wild_ones_ignored() -> None:
    rig = Rig(nominal_model(), T)
    for command, applied in ((500.0, 160.0), (-1.0, 0.0), (30.0, 30.0), (math.nan, 30.0)):
        rig.command(command)
        rig.tick()
        assert rig.voltage == applied
    rig.command(math.inf)
    assert (rig.clipped, rig.refused) == (2, 2)


def test_a_command_during_missed_ticks_waits_for_the_next_one() -> None:
    rig = Rig(nominal_model(), 1e-3)
    rig.command(50.0)
    rig.tick()
    rig.command(100.0)
    rig.miss()
    assert rig.voltage == 50.0
    rig.tick()
    assert rig.voltage == 100.0
    held = simulate(nominal_model(), np.array([50.0, 50.0, 100.0, 100.0]), 1e-3)
    assert rig.position == held[2]


@pytest.mark.parametrize(("asked", "begins"), [(120.0, 120.0), (160.02, 160.0), (-0.1, 0.0)])
def test_it_begins_at_rest_where_it_is_asked_to_within_its_range(
    asked: float, begins: float
) -> None:
    """A recording's first voltage may lie a reading's noise beyond it."""
    rig = Rig(nominal_model(), T, asked)
    positions = []
    for _ in range(3):
        rig.tick()
        assert rig.voltage == begins
        positions.append(rig.position)
    assert positions == pytest.approx(positions[:1] * 3, rel=1e-12)
    assert rig.clipped == 0
