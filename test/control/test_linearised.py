"""The linear hysteresis against closed forms and an independent integration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised

T = 1e-3


def test_without_memory_h_is_in_proportion_to_the_voltage() -> None:
    voltage = np.random.default_rng(0).uniform(0.0, 160.0, 200)
    assert Linearised(2e-8, 0.0).hysteresis(voltage, T) == pytest.approx(2e-8 * voltage)


def test_h_of_a_held_voltage_decays() -> None:
    h = Linearised(2e-8, -5.0).hysteresis(np.full(1000, 100.0), T)
    assert h == pytest.approx(2e-6 * np.exp(-5.0 * T * np.arange(1, 1001)))


def test_a_smooth_voltage_agrees_with_an_integrated_equation() -> None:
    linear = Linearised(2.3e-8, -1.6)
    fine = 1e-4
    time = fine * np.arange(20_001)
    h = linear.hysteresis(80.0 * (1.0 - np.cos(2.0 * np.pi * time)), fine)

    def rate(t: float, h: np.ndarray) -> np.ndarray:
        speed = 160.0 * np.pi * np.sin(2.0 * np.pi * t)
        return linear.k1 * speed + linear.k2 * h

    truth = solve_ivp(rate, (0.0, 2.0), [0.0], rtol=1e-9, atol=1e-15, t_eval=time[1::1000])
    # Held over a step the voltage is half a step late, and h is read at the step's end.
    assert h[:-1:1000] == pytest.approx(truth.y[0], abs=2e-3 * np.abs(h).max())


@pytest.mark.parametrize("k2", [-20.0, -0.533, 0.0])
def test_the_inverse_returns_to_the_wanted_displacement(identified: Identified, k2: float) -> None:
    linear = Linearised(2.3e-8, k2)
    wanted = 1e-6 * np.cumsum(np.random.default_rng(1).normal(0.0, 0.3, 500))
    voltage = linear.voltage(identified, wanted, T)
    back = linear.displacement(identified, voltage, T)
    assert back == pytest.approx(wanted, abs=1e-15)


def test_the_static_gain_without_hysteresis_is_k(identified: Identified) -> None:
    voltage = np.array([0.0, 50.0, 160.0])
    moved = Linearised(0.0, -1.0).displacement(identified, voltage, T)
    assert moved == pytest.approx(identified.gain * voltage)
