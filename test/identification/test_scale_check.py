"""Wrong units and a turned sensor are told; a rig that is mistuned or late is not."""

from __future__ import annotations

import re

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.scale_check import scale_warnings
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3
VOLTAGE = 75.0 - 70.0 * np.cos(2.0 * np.pi * 1.3 * PERIOD * np.arange(4000))


def warned(factor: float, volts: float = 1.0) -> list[str]:
    rig = nominal_model().with_link("transport_delay", delay=20e-3)
    noise = 1e-8 * np.random.default_rng(1).standard_normal(len(VOLTAGE))
    displacement = factor * (simulate(rig, VOLTAGE, PERIOD) + noise)
    recording = Recording("run", PERIOD, volts * VOLTAGE, displacement)
    return scale_warnings(nominal_model(), [recording], Conditions())


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_a_mistuned_rig_passes(factor: float) -> None:
    assert warned(factor) == []


def test_micrometres_are_told() -> None:
    (line,) = warned(1e6)
    assert "000 times as far as the model" in line
    assert "--map" in line


def test_volts_before_the_amplifier_are_told() -> None:
    (line,) = warned(1.0, volts=1.0 / 15.0)
    assert re.search(r"move 1[3-7] times as far as the model", line)


def test_a_turned_sensor_is_told() -> None:
    (line,) = warned(-1.0)
    assert "go down where the model goes up" in line
    assert "--map displacement=NAME*-1" in line


@pytest.mark.parametrize("seed", range(10))
def test_a_sensor_that_sees_nothing_is_told(seed: int) -> None:
    shown = 1e-8 * np.random.default_rng(seed).standard_normal(len(VOLTAGE))
    run = Recording("run", PERIOD, VOLTAGE, shown)
    (line,) = scale_warnings(nominal_model(), [run], Conditions())
    assert "do not move with the voltage" in line


def test_a_rig_that_hardly_moves_in_its_noise_moves() -> None:
    little = VOLTAGE[0] + 0.002 * (VOLTAGE - VOLTAGE[0])
    noise = 1e-7 * np.random.default_rng(3).standard_normal(len(VOLTAGE))
    run = Recording("run", PERIOD, little, simulate(nominal_model(), little, PERIOD) + noise)
    assert scale_warnings(nominal_model(), [run], Conditions()) == []
