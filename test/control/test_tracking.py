"""Tracking on plants whose every parameter differs by 10 % from what the controller holds."""

from __future__ import annotations

import numpy as np
import pytest
from closed_loop import drive, perturbed

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.control.feedforward import InverseKind
from microgripper_control.control.identified import Identified
from microgripper_control.control.setpoints import Sine
from microgripper_control.plant.model import Model

T = 1e-3
CYCLE = 1000  # samples
SINE = Sine(low=3e-6, high=14.5e-6, frequency=1.0)  # within every plant's reach after a cycle
NOISE = 15e-9  # m: 0.13 % of the sine's peak to peak
SIGNS = [  # of d, alpha, beta, gamma, m, b, k, k_s
    (1, 1, 1, 1, 1, 1, 1, 1),
    (-1, -1, -1, -1, -1, -1, -1, -1),
    (1, -1, 1, -1, 1, -1, 1, -1),
    (-1, 1, -1, 1, -1, 1, -1, 1),
    (1, 1, -1, -1, 1, 1, -1, -1),
    (-1, -1, 1, 1, -1, -1, 1, 1),
    (1, -1, -1, 1, -1, 1, 1, -1),
    (-1, 1, 1, -1, 1, -1, -1, 1),
]


def tracking_error(
    model: Model,
    identified: Identified,
    mode: Mode,
    kind: InverseKind = InverseKind.EXACT,
    seed: int = 1,
) -> float:
    """Rms of setpoint minus recorded displacement after one cycle, in % of peak to peak."""
    rig = model.with_link("sensor_noise", std=NOISE, seed=seed)
    controller = Controller(identified, T, mode=mode, inverse=kind)
    setpoint = SINE.samples(4 * CYCLE, T)
    displacement, voltage = drive(rig, controller, setpoint)
    assert controller.limited == 0, f"out of reach: {voltage.max()} V"
    error = (setpoint - displacement)[CYCLE:]
    return 100.0 * float(np.sqrt(np.mean(error**2))) / np.ptp(setpoint)


@pytest.mark.parametrize("kind", InverseKind)
@pytest.mark.parametrize("signs", SIGNS)
def test_the_cascade_beats_its_parts_at_1_hz(
    model: Model, identified: Identified, signs: tuple[int, ...], kind: InverseKind
) -> None:
    rig = perturbed(model, signs)
    cascade = tracking_error(rig, identified, Mode.CASCADE, kind)
    assert cascade < 0.2
    assert cascade < 0.3 * tracking_error(rig, identified, Mode.PID)
    assert cascade < 0.1 * tracking_error(rig, identified, Mode.FEEDFORWARD, kind)


def test_on_the_plant_it_holds_only_the_noise_is_left(model: Model, identified: Identified) -> None:
    floor = 100.0 * NOISE / (SINE.high - SINE.low)
    assert tracking_error(model, identified, Mode.FEEDFORWARD) < 1.02 * floor
    # Feeding noise back adds to it: for g = 1/3 in z^2 - z + g by a factor sqrt(1 + 2/7).
    cascade = tracking_error(model, identified, Mode.CASCADE)
    assert cascade == pytest.approx(np.sqrt(9.0 / 7.0) * floor, rel=0.05)
