"""The inverse model's parameters and the compensators against planted truths."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from microgripper_control.control.feedforward import InverseKind
from microgripper_control.control.identified import Identified
from microgripper_control.paper.experiment import drive, record
from microgripper_control.paper.inverse import FAST_PERIODS, InverseResult, compensation_error
from microgripper_control.paper.inverse_fit import NAMES, fit_inverse
from microgripper_control.paper.setpoint import Tracking, approached_sine
from microgripper_control.plant.model import Model

T = 1e-3
REACH = (3e-6, 15e-6)


def test_below_the_first_turn_the_inverse_has_the_forward_parameters(
    plant: Model, identified: Identified
) -> None:
    gentle = replace(plant, voltage_range=(0.0, 150.0))
    voltage = drive(gentle, "triangle", 2)
    found = fit_inverse(record(gentle, voltage, "exact"), identified, "exact")
    for name in NAMES:
        assert found.values[name] == pytest.approx(getattr(identified, name), rel=1e-5)
    assert found.rmse < 1e-6
    assert found.predicted == pytest.approx(voltage[:-1], abs=1e-4)


def test_above_it_the_displacement_does_not_tell_the_voltage(
    plant: Model, identified: Identified
) -> None:
    found = fit_inverse(record(plant, drive(plant, "triangle", 1), "exact"), identified, "exact")
    assert 1e-3 < found.rmse < 0.1


def test_the_exact_inverse_leaves_nothing_at_1_khz_and_equation_6_a_step_of_h(
    plant: Model, identified: Identified
) -> None:
    def error(kind: InverseKind, period: float) -> Tracking:
        setpoint, start = approached_sine(REACH, 1.0, 2, period)
        return compensation_error(plant, identified, kind, setpoint, start, period)

    exact, explicit = error(InverseKind.EXACT, T), error(InverseKind.PAPER, T)
    twice_as_often = error(InverseKind.PAPER, T / 2.0)
    assert exact.largest < 1e-6
    assert 0.01 < explicit.rms < 0.1
    assert twice_as_often.rms == pytest.approx(explicit.rms / 2.0, rel=0.02)


def test_equation_6_is_the_better_one_where_the_mechanics_is_resolved(
    plant: Model, identified: Identified
) -> None:
    fine = 1e-6
    setpoint, start = approached_sine(REACH, 1000.0, 2, fine)
    exact, explicit = (
        compensation_error(plant, identified, kind, setpoint, start, fine)
        for kind in (InverseKind.EXACT, InverseKind.PAPER)
    )
    assert explicit.rms < 0.3 * exact.rms
    # What the exact inverse leaves is the lag b/(k + k_s) of the damper, less the half step held.
    lag = identified.b / (identified.k + identified.k_s) - fine / 2.0
    swing = 2.0 * np.pi * 1000.0 * lag / (2.0 * np.sqrt(2.0))
    assert exact.rms == pytest.approx(100.0 * swing, rel=0.1)


@pytest.mark.parametrize(
    ("better", "told"),
    [
        ([6], "above it the exact inverse"),
        ([6, 9, 11], "above it the exact inverse but for 26 to 56 µs"),
        ([6, 9], "above it the exact inverse but for 26 to 100 µs"),
        ([], ""),
    ],
)
def test_which_compensator_is_better_is_told_of_all_periods(better: list[int], told: str) -> None:
    """`better` are the places, from the shortest period on, where the other takes over."""
    turns = np.isin(np.arange(len(FAST_PERIODS)), better)
    exact = np.where(np.cumsum(turns) % 2, 0.5, 2.0)[::-1]
    errors = {
        InverseKind.PAPER: tuple(np.ones(len(FAST_PERIODS)).tolist()),
        InverseKind.EXACT: tuple(exact.tolist()),
    }
    none: Any = None
    result = InverseResult(none, none, none, {}, {}, FAST_PERIODS, errors)
    assert result._above == told
    assert len(result.crossings) == len(better)
    if better:
        assert result.crossing == pytest.approx(10**-5.083, rel=1e-3)  # half way, logarithmically
