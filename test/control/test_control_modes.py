"""The four modes, and what holds in all of them whatever comes in."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from closed_loop import drive, identified_from, perturbed
from hypothesis import given, settings
from hypothesis import strategies as st

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.control.feedforward import InverseKind
from microgripper_control.control.identified import Identified
from microgripper_control.control.limits import VoltageLimits
from microgripper_control.control.pid import PidGains
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Plant

T = 1e-3
NOMINAL = identified_from(nominal_model())
CLOSED = [Mode.FEEDFORWARD, Mode.PID, Mode.CASCADE]
FADE = 2000.0 * T  # V a tick


def loop(
    plant: Plant, controller: Controller, setpoint: float | None, answer: float, ticks: int
) -> Array:
    """Run on from a plant that gets `answer`; the voltages given, V."""
    voltages = []
    for _ in range(ticks):
        x = plant.read()
        plant.write(answer)
        answer = controller.step(setpoint, x, answer)
        voltages.append(answer)
    return np.array(voltages)


@pytest.mark.parametrize("mode", CLOSED)
def test_brings_a_setpoint_that_stays_about(model: Model, mode: Mode) -> None:
    displacement, _ = drive(model, Controller(NOMINAL, T, mode=mode), np.full(400, 9e-6))
    assert displacement[-1] == pytest.approx(9e-6, abs=1e-13)


def test_open_loop_sends_the_voltage_out(model: Model) -> None:
    controller = Controller(NOMINAL, T, mode=Mode.OPEN_LOOP)
    command = 40.0 - 40.0 * np.cos(0.02 * np.arange(1000))
    _, voltage = drive(model, controller, command)
    np.testing.assert_array_equal(voltage[1:], command[:-1])


def test_an_open_loop_command_out_of_range_is_approached_and_counted() -> None:
    controller = Controller(NOMINAL, T, mode=Mode.OPEN_LOOP)
    answer = controller.start(150.0)
    answers = [controller.step(1e9, 0.0, 150.0) for _ in range(7)]
    assert answers == [answer, 152.0, 154.0, 156.0, 158.0, 160.0, 160.0]
    assert controller.limited == 7


def test_the_cascade_answers_a_step_after_the_loops_delay_without_overshoot(model: Model) -> None:
    limits = VoltageLimits(rate=1e6, ramp_rate=1e6)
    controller = Controller(NOMINAL, T, mode=Mode.CASCADE, limits=limits)
    setpoint = np.where(np.arange(400) < 200, 5e-6, 12e-6)
    displacement, _ = drive(model, controller, setpoint)
    assert np.abs(displacement[100:202] - 5e-6).max() < 1e-12
    # What little is left comes from the start, which the PID made along another voltage.
    np.testing.assert_allclose(displacement[202:], 12e-6, atol=1e-3 * 7e-6)


@pytest.mark.parametrize("start_rate", [2e4, 2e3])
def test_a_rate_limit_does_not_make_the_cascade_overshoot(model: Model, start_rate: float) -> None:
    limits = VoltageLimits(rate=start_rate)
    controller = Controller(NOMINAL, T, mode=Mode.CASCADE, limits=limits)
    setpoint = np.where(np.arange(400) < 200, 5e-6, 12e-6)
    displacement, voltage = drive(model, controller, setpoint)
    assert displacement[200:].max() < 12e-6 + 1e-3 * 7e-6
    assert np.abs(np.diff(voltage)).max() <= start_rate * T + 1e-9
    assert controller.limited > 0


@pytest.mark.parametrize(("before", "after"), list(itertools.permutations(CLOSED, 2)))
def test_a_change_of_mode_does_not_jump(model: Model, before: Mode, after: Mode) -> None:
    controller = Controller(NOMINAL, T, mode=before)
    plant = Plant(perturbed(model, [1, -1, 1, -1, 1, -1, 1, -1]), T)
    old = loop(plant, controller, 9e-6, controller.start(0.0), 300)
    controller.set_mode(after)
    new = loop(plant, controller, 9e-6, old[-1], 300)
    assert new[0] == pytest.approx(old[-1], abs=1e-9)
    if after is Mode.FEEDFORWARD:
        assert np.abs(np.diff(new)).max() <= FADE + 1e-9
    else:
        assert plant.read() == pytest.approx(9e-6, abs=1e-12)
    if before is not Mode.FEEDFORWARD and after is not Mode.FEEDFORWARD:
        assert np.abs(new - old[-1]).max() < 1e-6  # nothing was wrong: nothing moves


def test_the_first_error_of_a_cascade_is_no_kick() -> None:
    """It comes some ticks after the change: until then nothing was asked of the displacement."""
    gains = PidGains(kp=1.5e6, ki=5e8)
    steps = {}
    for mode in (Mode.PID, Mode.CASCADE):
        controller = Controller(NOMINAL, T, mode=Mode.OPEN_LOOP, gains=gains)
        plant = Plant(nominal_model(), T)
        loop(plant, controller, 58.0, controller.start(0.0), 200)
        controller.set_mode(mode)
        voltages = loop(plant, controller, 4e-6, 58.0, 60)
        steps[mode] = np.max(np.abs(np.diff(voltages)))
        loop(plant, controller, 4e-6, voltages[-1], 400)
        assert plant.read() == pytest.approx(4e-6, abs=1e-9)
    assert steps[Mode.CASCADE] < 1.5 * steps[Mode.PID]


@pytest.mark.parametrize("mode", CLOSED)
def test_between_open_loop_and_the_others_the_voltage_waits_for_a_new_command(
    model: Model, mode: Mode
) -> None:
    controller = Controller(NOMINAL, T, mode=Mode.OPEN_LOOP)
    plant = Plant(model, T)
    old = loop(plant, controller, 80.0, controller.start(0.0), 200)
    assert old[-1] == 80.0
    controller.set_mode(mode)
    np.testing.assert_array_equal(loop(plant, controller, None, 80.0, 5), 80.0)
    new = loop(plant, controller, 12e-6, 80.0, 200)
    assert new[0] == 80.0
    assert plant.read() == pytest.approx(12e-6, abs=1e-12)
    controller.set_mode(Mode.OPEN_LOOP)
    np.testing.assert_array_equal(loop(plant, controller, None, new[-1], 5), new[-1])


@pytest.mark.parametrize("mode", Mode)
def test_begins_at_the_voltage_that_the_plant_reports(mode: Mode) -> None:
    controller = Controller(NOMINAL, T, mode=mode)
    command = 10.0 if mode is Mode.OPEN_LOOP else 3e-6
    assert controller.start(60.0) == 60.0
    assert controller.step(None, 8e-6, 60.0) == 60.0
    assert controller.step(command, 8e-6, 60.0) == pytest.approx(60.0, abs=1e-12)


def test_new_gains_and_new_values_do_not_jump(model: Model) -> None:
    controller = Controller(NOMINAL, T)
    plant = Plant(perturbed(model, [1] * 8), T)
    old = loop(plant, controller, 9e-6, controller.start(0.0), 300)
    gains = PidGains(kp=1e6, ki=1e9, kd=200.0)
    controller.set_gains(gains)
    assert controller.gains is gains
    new = loop(plant, controller, 9e-6, old[-1], 100)
    assert np.abs(new - old[-1]).max() < 1e-6
    controller.set_identified(replace(NOMINAL, d=1.1 * NOMINAL.d, alpha=0.09))
    last = loop(plant, controller, 9e-6, new[-1], 300)
    assert last[0] == pytest.approx(new[-1], abs=1e-9)
    assert plant.read() == pytest.approx(9e-6, abs=1e-11)


def test_values_for_a_narrower_range_than_the_limits_are_refused(model: Model) -> None:
    controller = Controller(NOMINAL, T)
    with pytest.raises(
        MicrogripperError, match=r"limits 0 \.\. 160 V exceed .* range 0 \.\. 100 V"
    ):
        controller.set_identified(replace(NOMINAL, voltage_range=(0.0, 100.0)))
    assert controller.reach == NOMINAL.reach(0.0, 160.0)
    with pytest.raises(MicrogripperError, match="sample period 0 s must be positive"):
        Controller(NOMINAL, 0)


@pytest.mark.parametrize("mode", CLOSED)
@pytest.mark.parametrize("unreachable", [0.3e-6, 50e-6, -1.0])
def test_a_setpoint_out_of_reach_is_reported_and_leaves_no_windup(
    model: Model, mode: Mode, unreachable: float
) -> None:
    controller = Controller(NOMINAL, T, mode=mode)
    steps = [(16e-6, 300), (unreachable, 1000), (8e-6, 60)]
    setpoint = np.concatenate([np.full(ticks, level) for level, ticks in steps])
    displacement, voltage = drive(model, controller, setpoint)
    if unreachable < 1e-6:
        assert voltage[1250] == 0.0
    else:  # the end of the reach, which this history has a little before the end of the range
        assert 155.0 < voltage[1250] <= 160.0
    assert displacement[-1] == pytest.approx(8e-6, abs=1e-3 * 8e-6)
    assert controller.clamped == (0 if unreachable == 0.3e-6 else 1000)


def test_a_cascade_at_the_end_of_the_range_recovers_as_fast_as_the_voltage_allows(
    model: Model,
) -> None:
    weak = perturbed(model, [-1] * 8)
    limits = VoltageLimits(rate=1e6, ramp_rate=1e6)
    controller = Controller(NOMINAL, T, limits=limits)
    setpoint = np.where(np.arange(3000) < 2000, 19e-6, 10e-6)
    displacement, voltage = drive(weak, controller, setpoint)
    assert voltage[1990] == 160.0
    error = np.abs(displacement[2000:] - 10e-6)
    assert error[2] < 0.25 * 9e-6  # the feedforward's own share of the 10 %
    assert error[15:].max() < 0.01 * 9e-6


anything = st.floats(allow_nan=True, allow_infinity=True)
commands = st.none() | anything | st.floats(0.0, 2e-5)


@settings(max_examples=150, deadline=None)
@given(
    st.sampled_from(Mode),
    st.sampled_from(InverseKind),
    st.lists(st.tuples(commands, anything | st.floats(0.0, 2e-5), anything), max_size=25),
)
def test_every_voltage_is_sane_and_tracking_returns_whatever_comes_in(
    mode: Mode, kind: InverseKind, samples: list[tuple[float | None, float, float]]
) -> None:
    gains = PidGains(kp=5e5, ki=1e9, kd=100.0)
    controller = Controller(NOMINAL, T, mode=mode, inverse=kind, gains=gains)
    last = controller.start(30.0)
    for command, displacement, applied in samples:
        answer = controller.step(command, displacement, applied)
        assert 0.0 <= answer <= 160.0
        assert abs(answer - last) <= 2e4 * T + 1e-9
        last = answer
    plant = Plant(nominal_model(), T)
    wanted = 50.0 if mode is Mode.OPEN_LOOP else 8e-6
    voltages = loop(plant, controller, wanted, last, 600)
    assert np.all(np.isfinite(voltages))
    if mode is Mode.OPEN_LOOP:
        assert voltages[-1] == 50.0
    else:
        # Nothing corrects a feedforward that was told of voltages the plant never got.
        slack = 4e-6 if mode is Mode.FEEDFORWARD else 1e-9
        assert plant.read() == pytest.approx(8e-6, abs=slack)


def test_a_bad_sample_is_counted_and_the_last_good_one_stands_in(model: Model) -> None:
    controller = Controller(NOMINAL, T)
    plant = Plant(model, T)
    old = loop(plant, controller, 9e-6, controller.start(0.0), 300)
    for bad in (math.nan, math.inf):
        np.testing.assert_allclose(loop(plant, controller, bad, old[-1], 3), old[-1], atol=1e-6)
    assert controller.refused == 6
    assert controller.step(9e-6, math.nan, math.nan) == pytest.approx(old[-1], abs=1e-6)


@pytest.mark.parametrize("dead_time", [1e-3, 3e-3, 10e-3])
def test_the_cascade_does_not_act_twice_within_the_dead_time(
    model: Model, dead_time: float
) -> None:
    """What the feedforward has done and the plant does not show yet is no error."""
    rig = model.with_link("transport_delay", delay=dead_time)
    identified = replace(NOMINAL, dead_time=dead_time)
    limits = VoltageLimits(rate=1e6, ramp_rate=1e6)
    controller = Controller(identified, T, mode=Mode.CASCADE, limits=limits)
    setpoint = np.where(np.arange(600) < 300, 4e-6, 12e-6)
    displacement, _ = drive(rig, controller, setpoint)
    assert displacement[300:].max() < 12e-6 + 0.01 * 8e-6
    assert displacement[-1] == pytest.approx(12e-6, abs=1e-9)


def test_back_in_a_feedforward_that_differentiates_the_setpoint_is_one_that_was_held() -> None:
    """Equation (6) must not take the way between two spells of its mode for a step."""
    heavy = nominal_model().with_values({("second_order", "m"): 0.5, ("second_order", "b"): 2e3})
    fast = 1e-4
    controller = Controller(
        identified_from(heavy), fast, mode=Mode.FEEDFORWARD, inverse=InverseKind.PAPER
    )
    plant, answer = Plant(heavy, fast), controller.start(0.0)
    answer = loop(plant, controller, 4e-6, answer, 400)[-1]
    controller.set_mode(Mode.PID)
    answer = loop(plant, controller, 12e-6, answer, 4000)[-1]
    controller.set_mode(Mode.FEEDFORWARD)
    assert loop(plant, controller, 12e-6, answer, 200) == pytest.approx(answer, abs=1.0)


def test_an_open_loop_command_out_of_range_counts_as_out_of_reach() -> None:
    controller = Controller(NOMINAL, T, mode=Mode.OPEN_LOOP)
    controller.start(160.0)
    for _ in range(5):
        controller.step(500.0, 0.0, 160.0)
    controller.step(100.0, 0.0, 160.0)
    assert controller.clamped == 5
    controller.forget_counts()
    assert controller.clamped == 0


@pytest.mark.parametrize("mode", CLOSED)
@pytest.mark.parametrize("zero", [5e-6, -3e-6])
def test_a_sensor_that_does_not_read_zero_at_rest_is_no_error(
    model: Model, mode: Mode, zero: float
) -> None:
    """The setpoint is what the sensor is to read: else a feedforward is off by all of its zero."""
    setpoint = 9e-6 + 4e-6 * np.sin(0.02 * np.arange(600))
    expected, voltages = drive(model, Controller(NOMINAL, T, mode=mode), setpoint)
    shifted = model.with_link("sensor_zero", offset=zero)
    knowing = Controller(Identified.of(shifted), T, mode=mode)
    found, given_voltages = drive(shifted, knowing, setpoint + zero)
    np.testing.assert_allclose(found - zero, expected, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(given_voltages, voltages, rtol=0.0, atol=1e-7)


def test_what_can_be_reached_is_told_as_the_sensor_reads_it(model: Model) -> None:
    usual = Controller(NOMINAL, T)
    knowing = Controller(Identified.of(model.with_link("sensor_zero", offset=5e-6)), T)
    assert knowing.reach == pytest.approx([end + 5e-6 for end in usual.reach])
    knowing.start(0.0)
    knowing.step(usual.reach[1] + 4e-6, 5e-6, 0.0)
    assert knowing.clamped == 0
    knowing.step(4e-6, 5e-6, 0.0)
    assert knowing.clamped == 1
