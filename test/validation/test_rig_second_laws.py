"""Second laws of the rig that no one looks at while the diagnosis is developed: nor at this file.

They stand apart from the tests of the other laws because those are read.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rig_runs import PAPER, STEP, STEPS, answer, applied, element, lively, reading, rms
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from microgripper_control.validation.effects.form import Reach
from microgripper_control.validation.effects.registry import form_of
from microgripper_control.validation.law import Taken
from microgripper_control.validation.machine import Rig
from microgripper_control.validation.oracle import errors_known, explain


def test_the_lag_agrees_with_solve_ivp_up_and_down() -> None:
    def u(t: float) -> float:
        return 60.0 + 50.0 * math.sin(2.0 * math.pi * 40.0 * t)

    def rate(t: float, v: list[float]) -> list[float]:
        away = u(t) - v[0]
        return [away / (1.6e-3 if away > 0.0 else 2.4e-3)]

    t = STEP * np.arange(1, 8001)
    made = element("amplifier_lag", "b", 2e-3, weaker=1.5)
    # Before its first value an element has only seen zero: that step is a jump for it.
    found = answer(made, np.array([u(one) for one in t]), slant=0.0)
    solved = solve_ivp(rate, (0.0, t[-1]), [0.0], t_eval=t, rtol=1e-9, atol=1e-9, max_step=1e-3)
    assert found == pytest.approx(solved.y[0], abs=0.1)
    equal = answer(element("amplifier_lag", "b", 2e-3, weaker=1.0), np.array([u(one) for one in t]))
    assert rms(equal - solved.y[0]) > 1.0


@pytest.mark.parametrize(("slope", "late"), [(1000.0, 1.6e-3), (-1000.0, 2.4e-3)])
def test_the_lag_follows_a_ramp_by_the_time_constant_of_its_direction(
    slope: float, late: float
) -> None:
    ramp = slope * STEP * np.arange(1, 4001)
    found = answer(element("amplifier_lag", "b", 2e-3, weaker=1.5), ramp)
    assert (ramp - found)[-1] == pytest.approx(slope * late, rel=1e-6)


def test_a_held_jump_is_lagged_the_same_on_any_grid() -> None:
    jump = np.concatenate([np.full(200, 100.0), np.full(200, 20.0)])
    fine = answer(element("amplifier_lag", "b", 1e-3), np.repeat(jump, 10), slant=0.0)
    coarse = answer(element("amplifier_lag", "b", 1e-3, 10.0 * STEP), jump, 0.0, 10.0 * STEP)
    assert coarse == pytest.approx(fine[9::10], abs=1e-9)


@pytest.mark.parametrize("cycle", [0.15, 0.4])
def test_the_delay_is_that_of_points_joined_by_lines(cycle: float) -> None:
    delay, phase = 8e-3, 0.3
    t = STEP * np.arange(0, 12_001)
    u = 80.0 - 80.0 * np.cos(2.0 * np.pi * 12.0 * t)
    made = element("transport_delay", "b", delay, cycle=cycle, cycle_phase=phase)
    found = answer(made, u[1:])
    points = cycle * delay * (phase + np.arange(-1.0, 200.0))
    expected = np.interp(t - delay, points, np.interp(points, t, u))[1:]
    assert found == pytest.approx(expected, abs=2e-3)
    pure = np.interp(t - delay, t, u)[1:]
    assert np.abs(found - pure).max() > 0.05


def test_a_ramp_is_late_by_the_delay_and_a_jump_takes_a_cycle() -> None:
    made = element("transport_delay", "b", 6e-3, cycle=0.25)
    t = STEP * np.arange(1, 6001)
    assert (t - answer(made, t.copy()))[1000:] == pytest.approx(np.full(5000, 6e-3), rel=1e-6)
    made = element("transport_delay", "b", 6e-3, cycle=0.25)
    found = answer(made, np.full(2000, 50.0), slant=0.0)
    moving = np.flatnonzero((found > 0.0) & (found < 50.0))
    assert len(moving) == pytest.approx(150, abs=2)
    assert 4.4e-3 < moving[0] * STEP < 6.1e-3
    assert np.diff(found[moving[1:-1]]) == pytest.approx(np.full(len(moving) - 3, 50.0 / 150.0))


def test_the_saturation_solves_its_circuit() -> None:
    depth, bend = 0.25, 0.2
    u = np.linspace(0.0, 175.0, 351)
    v = answer(element("saturation", "b", depth, bend=bend), u)
    knee, width = 120.0, 8.0
    expected = [
        brentq(lambda w, here=one: w + width * np.exp((w - knee) / width) - here, -50.0, 200.0)
        for one in u
    ]
    assert v == pytest.approx(expected, abs=1e-8)
    assert v[u <= 40.0] == pytest.approx(u[u <= 40.0], abs=1e-3)
    assert (np.diff(v) > 0.0).all()


def test_the_saturation_shows_where_its_place_is() -> None:
    form = form_of("saturation", "b")
    reach = Reach(1e-3, (0.0, 160.0), (0.0, 2e-5), 1e3, 0.0, 10.0, PAPER.scale)
    for bend in (0.08, 0.25):
        (place,) = form.where(0.2, {"bend": bend}, reach)
        assert (place.axis, place.high) == ("voltage_V", 160.0)
        u = np.array([place.low, place.low + 4.0 * bend * 32.0, 160.0])
        lost = u - answer(element("saturation", "b", 0.2, bend=bend), u)
        assert lost[0] < 0.05 * lost[2]
        assert lost[1] > 0.1 * lost[2]
    assert form.where(0.05, {"bend": 0.1}, replace(reach, voltage=(0.0, 100.0))) == []


def step_at(x: np.ndarray, size: float, widest: float) -> np.ndarray:
    """The step in each range, from the binary exponent of the position."""
    exponent = np.frexp(np.maximum(np.abs(x), 1e-30) / (widest * PAPER.scale.top))[1] - 1
    return size * 2.0 ** np.clip(np.where(exponent >= 0, 0, exponent), -3, 0)


def test_readings_lie_on_the_steps_of_their_range() -> None:
    size, widest = 2e-7, 0.6
    made = element("sensor_quantization", "b", size, widest=widest)
    x = PAPER.scale.top * np.linspace(-1.0, 1.0, 20_001)
    found = answer(made, x)
    step = step_at(x, size, widest)
    assert set(np.round(step / size, 6)) == {1.0, 0.5, 0.25, 0.125}
    assert found / step == pytest.approx(np.round(found / step), abs=1e-6)
    assert (np.abs(found - x) <= 0.5 * step * (1.0 + 1e-9)).all()
    for part in (1.0, 0.5, 0.25, 0.125):
        off = (found - x)[step == part * size]
        assert rms(off) == pytest.approx(part * size / math.sqrt(12.0), rel=0.05)


def test_the_converter_leaves_its_oracle_more_than_the_noise() -> None:
    noise, size, widest = 15e-9, 30e-9, 0.5
    base = PAPER.base.scaled({"d": 1.1, "alpha": 0.9})
    rig = Rig(base, PAPER.scale, (applied("sensor_quantization", "b", size, widest=widest),))
    data = []
    for name in ("recording_1", "heldout_1"):
        drive = lively(6300, past=300)
        data.append(Taken(name, drive, reading(rig, drive, STEPS, noise, 1) + 2e-6, (1,)))
    step = step_at(data[0].measured - 2e-6, size, widest)
    left = math.hypot(noise, rms(step) / math.sqrt(12.0))
    known = errors_known(data, rig, noise, STEPS)["all"]
    assert known == pytest.approx(left, rel=0.04)
    assert explain(data, PAPER.scale, noise).errors["all"] == pytest.approx(left, rel=0.1)
    assert left < 0.97 * math.hypot(noise, size / math.sqrt(12.0))
