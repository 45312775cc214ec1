"""Setpoints stay where every plant can follow."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.paper.behaviour import at_rest
from microgripper_control.paper.experiment import drive
from microgripper_control.paper.setpoint import (
    approached_sine,
    common_reach,
    mismatched,
    tracking_error,
)
from microgripper_control.plant.model import Model


def test_all_corners_are_10_per_cent_off(plant: Model) -> None:
    rigs = list(mismatched(plant))
    assert len({tuple(rig.values("bouc_wen").values()) for rig in rigs}) == 16
    for rig in rigs:
        for name in ("d", "alpha", "beta", "gamma"):
            ratio = rig.value("bouc_wen", name) / plant.value("bouc_wen", name)
            assert abs(ratio - 1.0) == pytest.approx(0.1)


def test_every_plant_reaches_the_common_range_in_every_cycle(plant: Model) -> None:
    rigs = [plant, *mismatched(plant)]
    low, high = common_reach(rigs)
    assert 0.0 < low < high
    for rig in rigs:
        cycles = at_rest(rig, drive(rig, "triangle", 5))[1000:].reshape(-1)
        assert cycles.min() <= low
        assert cycles.max() >= high


@pytest.mark.parametrize("frequency", [0.1, 1.0, 10.0, 1000.0])
def test_the_sine_begins_and_stays_in_its_range(frequency: float) -> None:
    period = 1.0 / (1000.0 * frequency)
    setpoint, start = approached_sine((3e-6, 15e-6), frequency, 2, period)
    sine = setpoint[start:]
    assert len(sine) == 2000
    assert sine.min() == pytest.approx(3e-6)
    assert sine.max() == pytest.approx(15e-6)
    assert setpoint[0] == 0.0
    assert np.abs(np.diff(setpoint)).max() < 0.1e-6


def test_errors_are_shares_of_the_setpoint() -> None:
    setpoint = np.array([0.0, 2.0, 0.0, 2.0])
    found = tracking_error(setpoint, setpoint - np.array([0.0, 0.1, -0.1, 0.0]))
    assert found.largest == pytest.approx(5.0)
    assert found.rms == pytest.approx(5.0 / np.sqrt(2.0))
