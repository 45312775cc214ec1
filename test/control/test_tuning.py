"""The margins against closed forms, and the gains they lead to against the loop itself."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_loop import drive
from scipy.signal import cont2discrete

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.control.identified import Identified
from microgripper_control.control.pid import Pid, PidGains
from microgripper_control.control.tuning import Margins, _loop, default_gains, loop_margins
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model
from microgripper_control.plant.model_file import load_model
from microgripper_control.plant.simulate import Plant

T = 1e-3
DATASHEET = Path(__file__).parents[2] / "config" / "apa120s_datasheet.yaml"


def test_margins_of_integral_action_on_a_settled_plant_have_a_closed_form(
    identified: Identified,
) -> None:
    for g in (0.05, 0.2, 0.5, 0.9):
        margins = loop_margins(identified, PidGains(ki=g / (identified.gain * T)), T)
        assert margins.gain == pytest.approx(1.0 / g, rel=1e-5)
        phase = 90.0 - math.degrees(3.0 * math.asin(0.5 * g))
        assert margins.phase == pytest.approx(phase, abs=1e-3)
        assert margins.crossover == pytest.approx(2.0 * math.asin(0.5 * g) / T, rel=1e-5)


@pytest.mark.parametrize("ticks", [1, 3, 20])
def test_a_dead_time_costs_the_margins_that_it_should(identified: Identified, ticks: int) -> None:
    """L = g / (z^d (z - 1)) with d = 1 + ticks: unstable from g = 2 sin(pi / (4 d + 2)) on."""
    late = replace(identified, dead_time=ticks * T)
    d, g = 1 + ticks, 0.04
    margins = loop_margins(late, PidGains(ki=g / (late.gain * T)), T)
    assert margins.gain == pytest.approx(2.0 * math.sin(math.pi / (4 * d + 2)) / g, rel=1e-4)
    phase = 90.0 - math.degrees((2 * d + 1) * math.asin(0.5 * g))
    assert margins.phase == pytest.approx(phase, abs=1e-3)


@pytest.mark.parametrize("ticks", [0, 1, 7, 40])
@pytest.mark.parametrize("kp", [0.0, 1e6])
def test_a_loop_is_stable_where_all_its_roots_lie_inside(
    identified: Identified, ticks: int, kp: float
) -> None:
    late = replace(identified, dead_time=ticks * T)
    for ki in np.geomspace(1e7, 3e9, 15):
        gains = PidGains(kp=kp, ki=float(ki))
        above, below = _loop(late, gains, T)
        whole = np.polyadd(np.append(below, np.zeros(1 + ticks)), above)
        stable = bool(np.all(np.abs(np.roots(whole)) < 1.0))
        assert (loop_margins(late, gains, T).gain > 0.0) == stable


def test_a_dead_time_of_many_ticks_takes_no_time(identified: Identified) -> None:
    late = replace(identified, dead_time=1.0)
    gains = default_gains(late, 1e-4)
    assert loop_margins(late, gains, 1e-4).gain > 2.0
    assert gains.ki == pytest.approx(1.0 / (2.0 * late.gain), rel=0.05)


@pytest.mark.parametrize("rate", [1e3, 2e3, 5e3, 20e3])
def test_a_rig_that_answers_late_is_not_driven_into_swinging(rate: float) -> None:
    """The maker's figures: a sensor that lags by 2.7 ms, and a resonance at 1.3 kHz."""
    rig = load_model(DATASHEET)
    assert rig.dead_time > 2e-3
    values = replace(Identified.of(rig), ringing=0.0)
    gains = default_gains(values, 1.0 / rate)
    x = _step_response(rig, gains, 1.0 / rate, int(rate))
    assert np.ptp(x[-int(rate / 4) :]) < 0.02e-6
    deaf = default_gains(replace(values, dead_time=0.0), 1.0 / rate)
    assert (loop_margins(values, deaf, 1.0 / rate).gain == 0.0) is (rate > 1e3)


def test_margins_of_proportional_action_on_a_settled_plant_have_a_closed_form(
    identified: Identified,
) -> None:
    # L = p / z^2: the phase is -180 degrees at a quarter of the sampling rate, |L| = p throughout.
    for p in (0.25, 0.8):
        margins = loop_margins(identified, PidGains(kp=p / identified.gain, ki=0.0), T)
        assert margins.gain == pytest.approx(1.0 / p, rel=1e-5)
        assert (margins.phase, margins.crossover) == (math.inf, 0.0)


@pytest.mark.parametrize(
    "gains",
    [
        PidGains(kp=1.1e6, ki=1e9, kd=600.0, derivative_filter=0.002),
        PidGains(kp=2.5e6, ki=5e8, kd=0.0),
        PidGains(kp=5e5, ki=2e9, kd=2e3, derivative_filter=0.0),
    ],
)
def test_the_gain_margin_is_where_the_loop_turns_unstable(
    model: Model, identified: Identified, gains: PidGains
) -> None:
    straight = model.with_values({("bouc_wen", "alpha"): 0.0})
    margin = loop_margins(identified, gains, T).gain
    assert 1.0 < margin < 20.0
    for factor, grows in [(0.97 * margin, False), (1.03 * margin, True)]:
        stronger = straight.with_values({("bouc_wen", "d"): identified.d * factor})
        assert grows == _grows(stronger, gains)


def _grows(model: Model, gains: PidGains) -> bool:
    swing = np.abs(np.diff(_step_response(model, gains, T, 400)))
    return bool(swing[-100:].max() > swing[100:200].max())


def _step_response(model: Model, gains: PidGains, sample_period: float, count: int) -> Array:
    plant, pid = Plant(model, sample_period), Pid(gains, sample_period)
    x, u = np.empty(count), 0.0
    for k in range(count):
        x[k] = plant.read()
        plant.write(u)
        u = pid.step((1e-6 if k > 3 else 0.0) - x[k], x[k])
    return x


@pytest.mark.filterwarnings("error")
def test_a_loop_that_does_nothing_crosses_nothing(identified: Identified) -> None:
    margins = loop_margins(identified, PidGains(ki=0.0), T)
    assert margins == Margins(math.inf, math.inf, 0.0)


def test_an_unstable_loop_has_no_margin(identified: Identified) -> None:
    margins = loop_margins(identified, PidGains(ki=1.1 / (identified.gain * T)), T)
    assert margins == Margins(0.0, 0.0, 0.0)


@pytest.mark.parametrize("sample_period", [1e-2, 1e-3, 2e-4, 5e-5])
@pytest.mark.parametrize("factor", [0.8, 1.0, 1.2])
def test_default_gains_keep_the_margins_when_the_plant_gain_is_off(
    identified: Identified, sample_period: float, factor: float
) -> None:
    gains = default_gains(identified, sample_period)
    margins = loop_margins(identified, gains, sample_period, factor)
    assert margins.gain > 2.0
    assert margins.phase > 45.0


def test_default_gains_follow_the_simc_rule_where_the_plant_settles(identified: Identified) -> None:
    gains = default_gains(identified, T)
    assert gains.ki == pytest.approx(1.0 / (2.0 * 1.5 * T * identified.gain))
    assert (gains.kp, gains.kd) == (0.0, 0.0)
    declared = PidGains()
    assert (declared.kp, declared.kd) == (0.0, 0.0)
    assert declared.ki == pytest.approx(gains.ki, rel=1e-3)


def test_an_undamped_resonance_has_no_default_gains(identified: Identified) -> None:
    with pytest.raises(MicrogripperError, match=r"b = 0 .* give gains"):
        default_gains(replace(identified, b=0.0), 1e-4)


def test_a_resonance_lowers_the_gain_until_the_loop_is_calm(
    model: Model, identified: Identified
) -> None:
    k, k_s, frequency = 5e5, 1e4, 1300.0
    m = (k + k_s) / (2.0 * math.pi * frequency) ** 2
    b = 0.04 * math.sqrt((k + k_s) * m)  # a damping ratio of 2 %
    ringing = replace(identified, m=m, b=b, k=k, k_s=k_s)
    gains = default_gains(ringing, 1e-4)
    assert gains.ki < 0.1 / (3.0 * 1e-4 * ringing.gain)
    assert loop_margins(ringing, gains, 1e-4, 1.2).gain > 2.0
    plant = model.with_values(
        {("second_order", name): value for name, value in zip("mbk", (m, b, k), strict=True)}
        | {("second_order", "k_s"): k_s}
    )
    response = _step_response(plant, gains, 1e-4, 1000)
    np.testing.assert_allclose(response[-100:], 1e-6, rtol=1e-3)


MODES = [  # share, natural frequency in Hz, damping ratio
    (0.1, 100.0, 0.02),
    (0.2, 30.0, 0.02),
    (0.2, 100.0, 0.02),
    (0.5, 200.0, 0.02),
    (1.0, 100.0, 0.02),
    (1.0, 10.0, 0.15),
    (-1.0, 60.0, 0.02),
    (5.0, 40.0, 0.1),
    (1.0, 950.0, 0.005),  # above half the sampling rate: seen at 50 Hz
]


def with_mode(
    model: Model, identified: Identified, mode: tuple[float, float, float], detuned: float = 1.0
) -> tuple[Model, Identified]:
    """A rig with a mode and what is known of it; the rig's frequency may be another by a factor."""
    share, frequency, damping = mode
    known = model.with_link("extra_resonance", share=share, frequency=frequency, damping=damping)
    rig = known.with_values({("extra_resonance", "frequency"): detuned * frequency})
    ringing = registry()["extra_resonance"].ringing(known.values("extra_resonance"))
    return rig, replace(identified, ringing=ringing)


@pytest.mark.parametrize("mode", MODES)
def test_what_a_mode_can_add_to_the_loop_is_bounded_and_not_by_far(
    model: Model, identified: Identified, mode: tuple[float, float, float]
) -> None:
    share, frequency, damping = mode
    u = np.append(np.geomspace(1e-3, 1e3, 20_001), 1.0 + damping * np.linspace(-3, 3, 601))
    added = share * (1.0 / (1.0 - u**2 + 2j * damping * u) - 1.0)
    largest = np.max(np.abs(added) / (math.tau * frequency * u))
    assert largest <= with_mode(model, identified, mode)[1].ringing < 1.4 * largest


@pytest.mark.parametrize("detuned", [0.9, 1.0, 1.1])
@pytest.mark.parametrize("mode", MODES)
def test_a_mode_behind_the_mechanics_is_not_driven_into_swinging(
    model: Model, identified: Identified, mode: tuple[float, float, float], detuned: float
) -> None:
    rig, known = with_mode(model, identified, mode, detuned)
    x, _ = drive(rig, Controller(known, T, mode=Mode.CASCADE), np.full(6000, 8e-6))
    np.testing.assert_allclose(x[-1000:], 8e-6, atol=1e-8)


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode[0] > 0.0])
def test_one_who_is_not_told_of_a_mode_drives_it_into_swinging(
    model: Model, identified: Identified, mode: tuple[float, float, float]
) -> None:
    rig, _ = with_mode(model, identified, mode)
    x, _ = drive(rig, Controller(identified, T, mode=Mode.CASCADE), np.full(4000, 8e-6))
    assert np.std(x[-1000:]) > 5e-6


@pytest.mark.parametrize("sample_period", [1e-3, 2e-4])
@pytest.mark.parametrize("mode", [*MODES, (0.2, 834.0, 0.02), (0.5, 700.0, 0.02)])
def test_the_margins_hold_with_the_mode_in_the_loop(
    model: Model, identified: Identified, mode: tuple[float, float, float], sample_period: float
) -> None:
    """Of the exactly sampled loop of a plant whose gain is 20 % higher than known."""
    _, known = with_mode(model, identified, mode)
    g = 1.2 * default_gains(known, sample_period).ki * known.gain * sample_period
    share, frequency, damping = mode
    omega = math.tau * frequency
    parts = (  # of q and q' / omega
        [[0.0, omega], [-omega, -2.0 * damping * omega]],
        [[0.0], [omega]],
        [[share, 0.0]],
        [[1.0 - share]],
    )
    a, b, c, d, _ = cont2discrete(tuple(map(np.array, parts)), sample_period)
    seen = abs((omega * sample_period + math.pi) % math.tau - math.pi)
    peak = seen + damping * omega * sample_period * np.linspace(-5.0, 5.0, 2001)
    angles = np.unique(np.append(np.geomspace(1e-5, math.pi, 20_001), peak))
    z = np.exp(1j * angles[(angles > 0.0) & (angles <= math.pi)])
    passed = (c @ np.linalg.solve(z[:, None, None] * np.eye(2) - a, b))[:, 0, 0]
    loop = g / (z - 1.0) * (passed + d[0, 0] / z)  # what passes at once is read a sample later
    crosses = np.signbit(loop.imag[:-1]) != np.signbit(loop.imag[1:])
    assert loop.real[:-1][crosses].min() > -0.5
    assert np.abs(np.angle(-loop[np.abs(loop) >= 1.0], deg=True)).min() > 45.0
