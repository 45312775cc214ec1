"""The voltage guard's invariants, for any input."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from microgripper_control.control.limits import VoltageGuard, VoltageLimits
from microgripper_control.core.errors import MicrogripperError

T = 1e-3
ROUNDING = 1e-9  # V

anything = st.floats(allow_nan=True, allow_infinity=True)
voltages = st.floats(-200.0, 200.0)


@st.composite
def guards(draw: st.DrawFn) -> VoltageGuard:
    low = draw(st.floats(-1000.0, 999.0))
    high = draw(st.floats(low + 0.5, 1000.0))
    rate = draw(st.floats(1.0, 1e6))
    limits = VoltageLimits(low, high, rate, draw(st.floats(low, high)), draw(st.floats(1.0, rate)))
    return VoltageGuard(limits, T)


@given(guards(), st.floats(-1e300, 1e300), st.lists(st.tuples(st.booleans(), anything | voltages)))
def test_every_voltage_is_finite_in_range_and_in_rate(
    guard: VoltageGuard, reported: float, commands: list[tuple[bool, float]]
) -> None:
    limits = guard.limits
    last = guard.start(reported)
    assert last == limits.clip(reported)
    for ramped, command in commands:
        answer = guard.ramp_to(command) if ramped else guard.step(command)
        rate = limits.ramp_rate if ramped else limits.rate
        assert limits.low <= answer <= limits.high
        assert abs(answer - last) <= rate * T + ROUNDING
        assert answer == guard.voltage
        last = answer


@given(guards(), anything | voltages)
def test_what_it_says_may_go_out_goes_out(guard: VoltageGuard, reported: float) -> None:
    if math.isfinite(reported):
        guard.start(reported)
    for goal in (guard.lowest, guard.highest):
        again = VoltageGuard(guard.limits, T)
        again.start(guard.voltage)
        assert again.step(goal) == goal


@given(guards(), voltages)
def test_a_ramp_arrives_in_the_time_its_rate_allows_and_stays(
    guard: VoltageGuard, reported: float
) -> None:
    limits = guard.limits
    distance = abs(guard.start(reported) - limits.safe)
    ticks = math.ceil(distance / (limits.ramp_rate * T)) + 1
    if ticks > 10_000:
        return
    for _ in range(ticks):
        guard.ramp_to(limits.safe)
    assert guard.voltage == limits.safe
    assert guard.ramp_to(limits.safe) == limits.safe


def test_not_a_number_repeats_the_last_voltage() -> None:
    guard = VoltageGuard(VoltageLimits(), T)
    guard.start(70.0)
    for command in (math.nan, math.inf, -math.inf):
        assert guard.step(command) == guard.ramp_to(command) == 70.0


def test_a_wish_within_the_limits_goes_out_unchanged() -> None:
    guard = VoltageGuard(VoltageLimits(), T)
    guard.start(70.0)
    assert guard.step(70.1234567) == 70.1234567
    assert guard.step(150.0) == 70.1234567 + 20.0


def test_a_plant_that_reports_no_voltage_is_refused() -> None:
    with pytest.raises(MicrogripperError, match="reports nan V; wait for a finite voltage"):
        VoltageGuard(VoltageLimits(), T).start(math.nan)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"low": 160.0}, "low = 160 V must be below high = 160 V"),
        ({"safe": -1.0}, r"safe = -1 V must lie within low \.\. high = 0 \.\. 160 V"),
        ({"ramp_rate": 3e4}, "ramp_rate = 30000 V/s must not exceed rate = 20000 V/s"),
        ({"rate": 0.0}, r"rate = 0 is outside its range 1 \.\. 1e\+09 V/s"),
    ],
)
def test_limits_that_contradict_each_other_are_named(
    values: dict[str, object], message: str
) -> None:
    with pytest.raises(MicrogripperError, match=message):
        VoltageLimits(**values)


@given(guards(), voltages, anything, st.floats(0.0, 2.0))
def test_voltages_that_come_too_fast_keep_the_rate_in_time(
    guard: VoltageGuard, reported: float, command: float, share: float
) -> None:
    before = guard.start(reported)
    guard.passed(share * T)
    answer = guard.step(command)
    assert abs(answer - before) <= guard.limits.rate * min(share, 1.0) * T + ROUNDING


@given(guards(), voltages, st.floats(-1e6, 1e6), st.floats(0.0, 1.0))
def test_beginning_again_the_rate_comes_before_what_is_reported(
    guard: VoltageGuard, first: float, again: float, elapsed: float
) -> None:
    before = guard.start(first)
    answer = guard.start(again, elapsed)
    assert guard.limits.low <= answer <= guard.limits.high
    assert abs(answer - before) <= guard.limits.rate * elapsed + ROUNDING
    if abs(guard.limits.clip(again) - before) < guard.limits.rate * elapsed - ROUNDING:
        assert answer == guard.limits.clip(again)


@given(guards(), voltages, st.floats(0.0, 2.0))
def test_a_ramp_that_is_stepped_too_fast_keeps_the_rate_in_time(
    guard: VoltageGuard, reported: float, share: float
) -> None:
    before = guard.start(reported)
    guard.passed(share * T)
    answer = guard.ramp_to(guard.limits.safe)
    most = min(guard.limits.ramp_rate * T, guard.limits.rate * min(share, 1.0) * T)
    assert abs(answer - before) <= most + ROUNDING
