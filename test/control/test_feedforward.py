"""The inverses against the plant they invert, and against each other."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from closed_loop import identified_from
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from microgripper_control.control.feedforward import (
    ExactInverse,
    Inverse,
    InverseKind,
    PaperInverse,
    make_inverse,
)
from microgripper_control.control.identified import Identified
from microgripper_control.core.signals import Array
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Plant

T = 1e-3
RANGE = (0.0, 160.0)
STROKE = 19.2e-6  # m, at 160 V on the first rise


def follow(model: Model, inverse: Inverse, setpoint: Array, sample_period: float = T) -> Array:
    """Displacement one step after each answer, m."""
    plant = Plant(model, sample_period)
    displacement = np.empty(len(setpoint))
    for k, wanted in enumerate(setpoint):
        voltage = inverse.step(wanted)
        plant.write(voltage)
        inverse.applied(voltage)
        displacement[k] = plant.read()
    return displacement


def sine(frequency: float, sample_period: float, cycles: int = 3) -> Array:
    k = np.arange(round(cycles / frequency / sample_period))
    return 9e-6 - 6e-6 * np.cos(2.0 * np.pi * frequency * sample_period * k)


def tracking_error(
    kind: InverseKind, model: Model, frequency: float, sample_period: float
) -> float:
    """Rms after the first cycle, relative to the peak to peak."""
    setpoint = sine(frequency, sample_period)
    inverse = make_inverse(kind, identified_from(model), RANGE, sample_period)
    error = follow(model, inverse, setpoint, sample_period) - setpoint
    return math.sqrt(np.mean(error[len(error) // 3 :] ** 2)) / 12e-6


def sharper(model: Model) -> Model:
    """Exponent 1.5, with rates that give a loop of about the same width."""
    names = {"n": 1.5, "beta": 0.0152 / math.sqrt(2e-6), "gamma": -0.0227 / math.sqrt(2e-6)}
    return model.with_values({("bouc_wen", name): value for name, value in names.items()})


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_the_exact_inverse_puts_the_plant_where_it_should_be(model: Model, exponent: float) -> None:
    model = model if exponent == 1.0 else sharper(model)
    rng = np.random.default_rng(1)
    levels = rng.uniform(4e-6, 15e-6, 200)
    setpoint = np.repeat(levels, 2)  # the second sample of each level is settled
    displacement = follow(model, ExactInverse(identified_from(model), RANGE), setpoint)
    assert np.abs(displacement - setpoint)[1::2].max() < 1e-9 * STROKE
    assert np.abs(displacement - setpoint)[0::2].max() < 1e-8 * STROKE  # exp(-b T / 2m) is left


def test_the_exact_inverse_agrees_with_a_root_finder(identified: Identified) -> None:
    v = identified
    rng = np.random.default_rng(2)
    for _ in range(50):
        u, h = rng.uniform(0.0, 160.0), 0.0
        h = advance(h, u, v.a, v.beta, v.gamma, v.n)
        turn = rng.uniform(0.0, u)
        h, u = advance(h, turn - u, v.a, v.beta, v.gamma, v.n), turn
        inverse = ExactInverse(v, RANGE)
        inverse._voltage, inverse._hysteresis = u, h
        wanted = rng.uniform(3e-6, 15e-6)

        def excess(voltage: float, u: float = u, h: float = h, wanted: float = wanted) -> float:
            later = advance(h, voltage - u, v.a, v.beta, v.gamma, v.n)
            return v.compliance * (v.d * voltage - later) - wanted

        rising = wanted > v.compliance * (v.d * u - h)
        expected = brentq(excess, u, 160.0, xtol=1e-13) if rising else brentq(excess, 0.0, u)
        assert inverse.step(wanted) == pytest.approx(expected, abs=1e-10)


def test_equation_6_is_what_the_paper_prints(identified: Identified) -> None:
    v = identified
    inverse = PaperInverse(v, (-1e3, 1e3), T)
    x = [3e-6, 4e-6, 4.5e-6]
    inverse.step(x[0])
    inverse.step(x[1])
    inverse.applied(50.0)
    acceleration = (x[2] - 2.0 * x[1] + x[0]) / T**2
    velocity = (x[2] - x[1]) / T
    kd = v.k * v.d
    expected = (
        v.m / kd * acceleration
        + v.b / kd * velocity
        + (1.0 / v.d + v.k_s / kd) * x[2]
        + inverse.hysteresis / v.d
    )
    assert inverse.hysteresis == advance(0.0, 50.0, v.a, v.beta, v.gamma, v.n)
    assert inverse.step(x[2]) == pytest.approx(expected, rel=1e-12)


def test_equation_6_lags_and_its_error_shrinks_with_the_sample_period(model: Model) -> None:
    errors = [tracking_error(InverseKind.PAPER, model, 10.0, T / step) for step in (1, 2, 4)]
    assert errors[0] > 1e-3
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 1.0, atol=0.15)
    assert tracking_error(InverseKind.EXACT, model, 10.0, T) < 1e-9


def test_equation_6_settles_on_a_setpoint_that_stays(model: Model, identified: Identified) -> None:
    inverse = PaperInverse(identified, RANGE, T)
    displacement = follow(model, inverse, np.repeat([12e-6, 6e-6, 9e-6], 50))
    np.testing.assert_allclose(displacement[49::50], [12e-6, 6e-6, 9e-6], atol=1e-9 * STROKE)


def test_equation_6_is_better_where_the_sampling_sees_a_slow_gripper_move(model: Model) -> None:
    k, k_s = 3.2e5, 1e4
    m = (k + k_s) / (2.0 * math.pi * 1300.0) ** 2
    values = {"k": k, "k_s": k_s, "m": m, "b": 1.4 * math.sqrt((k + k_s) * m)}
    slow = model.with_values({("second_order", name): value for name, value in values.items()})
    paper, exact = (
        tracking_error(kind, slow, 10.0, 2e-5) for kind in (InverseKind.PAPER, InverseKind.EXACT)
    )
    assert paper < 0.1 * exact
    paper, exact = (
        tracking_error(kind, slow, 10.0, T) for kind in (InverseKind.PAPER, InverseKind.EXACT)
    )
    assert exact < 0.1 * paper


def test_a_limit_that_comes_between_is_told_and_forgotten(
    model: Model, identified: Identified
) -> None:
    inverse, deaf = ExactInverse(identified, RANGE), ExactInverse(identified, RANGE)
    plant = Plant(model, T)
    applied = 0.0
    for wanted in [*np.repeat([15e-6, 5e-6], 60), 8e-6]:
        applied += min(max(inverse.step(wanted) - applied, -3.0), 3.0)  # V a tick
        plant.write(applied)
        inverse.applied(applied)
        deaf.applied(deaf.step(wanted + 3e-6))
    assert plant.read() == pytest.approx(inverse.displacement, abs=1e-9 * STROKE)
    applied = inverse.step(8.5e-6)
    plant.write(applied)
    assert plant.read() == pytest.approx(8.5e-6, abs=1e-8 * STROKE)
    assert abs(deaf.hysteresis - inverse.hysteresis) > 1e-8  # another history, another voltage


def test_a_setpoint_out_of_reach_gets_the_end_of_the_range(identified: Identified) -> None:
    for kind in InverseKind:
        inverse = make_inverse(kind, identified, (5.0, 150.0), T)
        inverse.applied(60.0)
        assert inverse.step(1.0) == 150.0
        assert inverse.step(-1.0) == 5.0


@given(
    st.lists(st.floats(-1e3, 1e3) | st.floats(0.0, 2e-5), max_size=20),
    st.sampled_from(InverseKind),
    st.sampled_from([1.0, 1.3]),
)
def test_every_answer_is_finite_and_in_range(
    setpoints: list[float], kind: InverseKind, exponent: float
) -> None:
    identified = Identified(
        *(1.4447e-7, 0.0801, 0.0152, -0.0227, exponent, 0.0038, 150.0, 5e7, 8.2e5), RANGE
    )
    inverse = make_inverse(kind, identified, RANGE, T)
    for setpoint in setpoints:
        voltage = inverse.step(setpoint)
        assert 0.0 <= voltage <= 160.0
        inverse.applied(voltage)
        assert math.isfinite(inverse.hysteresis)


def test_new_values_go_on_from_the_old_state(identified: Identified) -> None:
    old = ExactInverse(identified, RANGE)
    old.applied(120.0)
    old.applied(70.0)
    new = ExactInverse(replace(identified, alpha=0.1), RANGE)
    new.take_over(old)
    assert (new.voltage, new.hysteresis) == (70.0, old.hysteresis)
