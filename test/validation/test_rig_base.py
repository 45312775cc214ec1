"""The rig without effects against closed forms, solve_ivp and the package's own plant."""

from __future__ import annotations

import numpy as np
import pytest
from rig_runs import BIPOLAR, DATASHEET, PAPER, PERIOD, STEPS, lively, reading, rms
from scipy.integrate import solve_ivp

from microgripper_control.plant.model_file import parse_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.validation.base import Actuator, Base
from microgripper_control.validation.case_files import nominal_model
from microgripper_control.validation.drive import KNOTS, Drive
from microgripper_control.validation.hysteresis import free_course
from microgripper_control.validation.machine import Rig, steps_a_sample


def test_the_first_rise_is_the_closed_form() -> None:
    base = Base()
    u = np.linspace(0.0, 160.0, 9)
    rate = base.beta + base.gamma
    h = base.alpha * base.d / rate * (1.0 - np.exp(-rate * u))
    assert free_course(base.hysteresis, u) == pytest.approx(base.d * u - h, abs=1e-15)


def test_rising_and_falling_with_both_signs_of_h_agree_with_solve_ivp() -> None:
    base = Base()
    turns = [0.0, 80.0, -80.0, 30.0, -10.0]
    h = 0.0
    found = free_course(base.hysteresis, np.array(turns))
    for begin, end, w in zip(turns[:-1], turns[1:], found[1:], strict=True):
        toward = np.sign(end - begin)
        solved = solve_ivp(
            lambda u, y, s=toward: base.alpha * base.d - base.beta * s * y - base.gamma * abs(y),
            (begin, end),
            [h],
            rtol=1e-11,
            atol=1e-18,
            max_step=0.5,
        )
        h = float(solved.y[0, -1])
        assert w == pytest.approx(base.d * end - h, abs=2e-13)


def test_a_held_jump_rings_as_an_oscillator_does() -> None:
    base = Base(alpha=0.0)
    period = 5e-6
    u = np.full(60, 10.0)
    x = reading(Rig(base, PAPER.scale), Drive(period, 0, u), steps=16)
    t = period * np.arange(60)
    sigma = base.b / (2.0 * base.m)
    wd = np.sqrt(base.natural_frequency**2 - sigma**2)
    rest = base.k * base.d * 10.0 / base.stiffness
    ring = np.exp(-sigma * t) * (np.cos(wd * t) + sigma / wd * np.sin(wd * t))
    assert x == pytest.approx(rest * (1.0 - ring), abs=1e-9 * rest)


def test_a_smooth_voltage_agrees_with_solve_ivp() -> None:
    base = DATASHEET.base
    period, amplitude, w = 1e-4, 20.0, 2.0 * np.pi * 300.0
    fine = period / KNOTS * np.arange(200 * KNOTS)
    knots = amplitude * np.sin(w * fine)
    drive = Drive(period, 0, knots[::KNOTS].copy(), knots)
    x = reading(Rig(base, DATASHEET.scale), drive, steps=8 * KNOTS)

    def rates(t: float, y: list[float]) -> list[float]:
        u, du = amplitude * np.sin(w * t), amplitude * w * np.cos(w * t)
        h = y[2]
        dh = base.alpha * base.d * du - base.beta * abs(du) * h - base.gamma * du * abs(h)
        force = base.k * (base.d * u - h) - base.b * y[1] - base.stiffness * y[0]
        return [y[1], force / base.m, dh]

    times = period * np.arange(200)
    solved = solve_ivp(
        rates, (0.0, times[-1]), [0.0, 0.0, 0.0], t_eval=times, rtol=1e-9, atol=1e-15, max_step=2e-5
    )
    assert rms(x - solved.y[0]) < 6e-5 * rms(solved.y[0])  # knots join the sine by straight lines


@pytest.mark.parametrize("actuator", [PAPER, BIPOLAR, DATASHEET], ids=lambda one: one.name)
def test_the_package_s_own_plant_comes_to_the_same_numbers(actuator: Actuator) -> None:
    drive = lively(3000, actuator)
    mine = reading(Rig(actuator.base, actuator.scale), drive)
    model = parse_model(nominal_model(actuator), "rig")
    theirs = simulate(model, drive.samples, PERIOD)
    assert rms(mine - theirs) < 1e-6 * rms(theirs)


def test_a_finer_internal_grid_changes_nothing() -> None:
    for smooth in (False, True):
        drive = lively(2000, DATASHEET, smooth=smooth)
        rig = Rig(DATASHEET.base, DATASHEET.scale)
        assert rms(reading(rig, drive) - reading(rig, drive, 8 * STEPS)) < 2e-12


@pytest.mark.parametrize("rate", [200.0, 999.0, 1000.0, 20000.0])
def test_the_internal_grid_is_at_least_100_khz_and_holds_the_knots(rate: float) -> None:
    steps = steps_a_sample(1.0 / rate)
    assert steps * rate >= 100e3
    assert steps % KNOTS == 0


def test_the_actuators_are_the_paper_s_and_the_maker_s() -> None:
    assert PAPER.base.course([160.0])[0] == pytest.approx(19.2e-6, rel=0.02)
    assert PAPER.base.natural_frequency / (2.0 * np.pi) == pytest.approx(18.4e3, rel=0.01)
    assert DATASHEET.base.natural_frequency / (2.0 * np.pi) == pytest.approx(1300.0, rel=0.01)
    assert DATASHEET.base.stiffness == pytest.approx(0.33e6)
    assert DATASHEET.scale.stroke == pytest.approx(140e-6, rel=0.03)
