"""Forces inside the mechanics' solve against static balance, solve_ivp and transfer functions."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from rig_runs import DATASHEET, PERIOD, STEPS, applied, reading, rms
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from microgripper_control.validation.base import Base
from microgripper_control.validation.block import Array
from microgripper_control.validation.drive import KNOTS, Drive
from microgripper_control.validation.machine import Rig

SCALE = DATASHEET.scale
STRAIGHT = Base(**{**vars(DATASHEET.base), "alpha": 0.0})  # w = d u: the force laws alone


def smooth_sine(frequency: float, samples: int, period: float = 1e-4) -> tuple[Drive, Callable]:
    w = 2.0 * np.pi * frequency
    t = period / KNOTS * np.arange(samples * KNOTS)
    knots = 65.0 * (1.0 - np.cos(w * t))
    return Drive(period, 0, knots[::KNOTS].copy(), knots), lambda s: 65.0 * (1.0 - np.cos(w * s))


def solved(
    force: Callable[[float, float, list[float]], tuple[float, list[float]]],
    voltage: Callable[[float], float],
    samples: int,
    states: int,
    period: float = 1e-4,
) -> Array:
    """The position by solve_ivp for a force (x, v, states) -> (F, their rates)."""

    def rates(t: float, y: Array) -> list[float]:
        pushed, own = force(y[0], y[1], list(y[2:]))
        drive = STRAIGHT.k * STRAIGHT.d * voltage(t) + pushed
        return [y[1], (drive - STRAIGHT.b * y[1] - STRAIGHT.stiffness * y[0]) / STRAIGHT.m, *own]

    t = period * np.arange(samples)
    found = solve_ivp(
        rates, (0.0, t[-1]), [0.0] * (2 + states), t_eval=t, rtol=1e-8, atol=1e-13, max_step=5e-6
    )
    return np.asarray(found.y[0])


def settled(effect: str, form: str, strength: float, voltage: float, **given: float) -> float:
    """Where it rests under a voltage that has come up slowly."""
    ramp = np.concatenate([np.linspace(0.0, voltage, 1500), np.full(500, voltage)])
    rig = Rig(STRAIGHT, SCALE, (applied(effect, form, strength, **given),))
    return float(reading(rig, Drive(PERIOD, 0, ramp))[-1])


def hardening(x: float) -> float:
    return -0.4 * SCALE.base.stiffness * x * (1.0 - 1.0 / np.hypot(1.0, x / SCALE.stroke))


def softening(x: float) -> float:
    middle, width = SCALE.displacement(0.5), 0.3 * SCALE.stroke
    bend = np.log(np.cosh((x - middle) / width)) - np.log(np.cosh(middle / width))
    return 0.4 * SCALE.base.stiffness * 0.5 * width * (x / width + bend)


def hertz(x: float) -> float:
    touch, rough = SCALE.displacement(0.6), 0.02 * SCALE.stroke
    depth = rough * np.logaddexp(0.0, (x - touch) / rough)
    return -0.4 * SCALE.force * (depth / (SCALE.top - touch)) ** 1.5


@pytest.mark.parametrize(
    ("effect", "form", "law", "given"),
    [
        ("nonlinear_stiffness", "a", hardening, {"length": 1.0}),
        ("nonlinear_stiffness", "b", softening, {"middle": 0.5, "width": 0.3}),
        ("contact", "a", hertz, {"position": 0.6, "roughness": 0.02}),
    ],
)
def test_it_rests_where_the_forces_balance(
    effect: str, form: str, law: Callable[[float], float], given: dict[str, float]
) -> None:
    push = STRAIGHT.k * STRAIGHT.d * 140.0
    rest = brentq(lambda x: push - STRAIGHT.stiffness * x + law(x), 0.0, 3e-4, xtol=1e-16)
    assert settled(effect, form, 0.4, 140.0, **given) == pytest.approx(rest, rel=1e-5)


def test_a_lossy_contact_met_at_speed_agrees_with_solve_ivp() -> None:
    drive, voltage = smooth_sine(40.0, 600)
    made = applied("contact", "a", 0.3, position=0.5, loss=0.5, roughness=0.01)
    found = reading(Rig(STRAIGHT, SCALE, (made,)), drive)
    position = SCALE.displacement(0.5)
    stiffness = 0.3 * SCALE.force / (SCALE.top - position) ** 1.5
    loss = 0.5 / (0.01 * SCALE.stroke * SCALE.base.natural_frequency)

    def force(x: float, v: float, _: list[float]) -> tuple[float, list[float]]:
        depth = 0.01 * SCALE.stroke * np.logaddexp(0.0, (x - position) / (0.01 * SCALE.stroke))
        return -stiffness * depth**1.5 * (1.0 + np.clip(loss * v, -1.0, 1.0)), []

    expected = solved(force, voltage, 600, 0)
    assert found.max() > 1.1 * position
    assert rms(found - expected) < 2e-4 * rms(expected)


def test_the_elasto_plastic_bristle_agrees_with_solve_ivp() -> None:
    drive, voltage = smooth_sine(15.0, 1500)
    made = applied("friction", "a", 0.05, presliding=0.03, excess=0.4, elastic=0.4)
    found = reading(Rig(STRAIGHT, SCALE, (made,)), drive)
    slide = 0.05 * SCALE.force
    stiffness = slide / (0.03 * SCALE.stroke)
    damping = 0.3 * np.sqrt(stiffness * SCALE.base.m)

    def force(x: float, v: float, z: list[float]) -> tuple[float, list[float]]:
        limit = slide * (1.0 + 0.4 * np.exp(-((v / (0.5 * SCALE.stroke)) ** 2))) / stiffness
        part = z[0] / limit * np.sign(v)
        on = np.clip((part - 0.4) / 0.6, 0.0, 1.0)
        slip = on**2 * (3.0 - 2.0 * on)
        rate = v * (1.0 - slip * part)
        return -(stiffness * z[0] + damping * rate), [rate]

    expected = solved(force, voltage, 1500, 1)
    bare = reading(Rig(STRAIGHT, SCALE), drive)
    assert rms(found - expected) < 0.01 * rms(bare - expected)


def test_the_damper_with_a_back_force_agrees_with_solve_ivp() -> None:
    drive, voltage = smooth_sine(15.0, 1500)
    made = applied("restoring_force_hysteresis", "b", 0.3, yield_way=0.15, back=0.2)
    found = reading(Rig(STRAIGHT, SCALE, (made,)), drive)
    stiffness, give = 0.3 * SCALE.base.stiffness, 0.15 * SCALE.stroke

    def force(x: float, v: float, z: list[float]) -> tuple[float, list[float]]:
        over = (z[0] - 0.2 * (x - z[0])) / give
        return -stiffness * z[0], [v - abs(v) * np.sign(over) * abs(over) ** 3]

    expected = solved(force, voltage, 1500, 1)
    bare = reading(Rig(STRAIGHT, SCALE), drive)
    assert rms(found - expected) < 0.01 * rms(bare - expected)


@pytest.mark.parametrize(
    ("effect", "form"), [("friction", "b"), ("restoring_force_hysteresis", "a")]
)
def test_sliders_obey_masing_s_rule(effect: str, form: str) -> None:
    given = {"presliding": 0.02} if effect == "friction" else {"exponent": -0.3, "widest": 0.2}
    made = applied(effect, form, 0.1, **given)
    turns = [0.0, 100.0, 20.0, 100.0]
    legs = [np.linspace(a, b, 2001)[1:] for a, b in pairwise(turns)]
    voltage = np.concatenate([[0.0], *legs, np.full(50, 100.0)])
    drive = Drive(PERIOD, 0, voltage, np.repeat(voltage, KNOTS))
    x = reading(Rig(STRAIGHT, SCALE, (made,)), drive)
    force = STRAIGHT.stiffness * x - STRAIGHT.k * STRAIGHT.d * np.concatenate([[0.0], voltage[:-1]])
    first, back = slice(1, 2001), slice(2001, 4001)
    # On the way back the force is the first rise's, twice as large over twice the way.
    way = x[2001] - x[back]
    half = np.interp(0.5 * way, x[first], force[first])
    gone = force[back] - force[2001]
    assert gone[100:] == pytest.approx(-2.0 * half[100:], rel=0.03, abs=0.012 * abs(gone).max())


def test_a_sticky_object_holds_on_and_yields() -> None:
    given = {"position": 0.5, "branch": 0.5, "yield_time": 0.3}
    made = applied("contact", "b", 0.3, **given)
    rise = np.linspace(0.0, 140.0, 500)
    voltage = np.concatenate([rise, np.full(2500, 140.0), rise[::-1]])
    x = reading(Rig(STRAIGHT, SCALE, (made,)), Drive(PERIOD, 0, voltage))
    free = STRAIGHT.k * STRAIGHT.d * voltage / STRAIGHT.stiffness
    assert x[2900] > x[520] + 1e-8  # it yields under the hold
    held_back = (x - free)[3001:]
    position = SCALE.displacement(0.5)
    near = (x[3001:] < position) & (x[3001:] > position - 0.1 * (SCALE.top - position))
    assert held_back[near].max() > 1e-8  # it pulls below the touch


def test_the_finger_and_the_moving_mass_have_the_two_body_transfer_function() -> None:
    frequency, period = 300.0, 1e-4
    drive, _ = smooth_sine(frequency, 6000, period)
    made = applied("extra_resonance", "a", 0.5, tone=0.1, damping=0.05, mass=0.1)
    found = reading(Rig(STRAIGHT, SCALE, (made,)), drive, STEPS)
    s = 2j * np.pi * frequency
    w = 2.0 * np.pi * 300.0  # a tenth of 3000 Hz, the highest
    relative = -(s**2) / (s**2 + 2.0 * 0.05 * w * s + w**2)
    mass = 0.1 * 0.5 * SCALE.base.m
    reaction = mass * (w**2 + 2.0 * 0.05 * w * s) * relative
    direct = STRAIGHT.m * s**2 + STRAIGHT.b * s + STRAIGHT.stiffness
    expected = STRAIGHT.k * STRAIGHT.d / (direct - reaction) * (1.0 + 0.5 * relative)
    late = slice(3000, None)
    carrier = np.exp(-2j * np.pi * frequency * period * np.arange(6000))
    seen = ((found - found[late].mean()) * carrier)[late].sum()
    given = ((drive.samples - drive.samples[late].mean()) * carrier)[late].sum()
    assert seen / given == pytest.approx(expected, rel=3e-3)


def test_backlash_without_drag_is_the_play_operator() -> None:
    drive, _ = smooth_sine(5.0, 4000)
    made = applied("backlash", "a", 0.02, lag=1e-9)
    bare = reading(Rig(STRAIGHT, SCALE), drive)
    found = reading(Rig(STRAIGHT, SCALE, (made,)), drive)
    play, half = np.zeros(4000), 0.01 * SCALE.stroke
    for k in range(1, 4000):
        play[k] = min(max(play[k - 1], bare[k] - half), bare[k] + half)
    assert found == pytest.approx(play, abs=2e-9)
