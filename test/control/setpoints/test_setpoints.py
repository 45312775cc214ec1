"""What every setpoint must hold: sample k is sample k, alone or in an array."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from microgripper_control.control.setpoints import SETPOINTS, Sequence, Setpoint, make_setpoint
from microgripper_control.core.errors import MicrogripperError

PERIODS = [1e-3, 2e-4, 1.0 / 1024.0]


def drawn(kind: str, low: float, high: float, frequency: float) -> Setpoint:
    values: dict[str, object] = {"low": low, "high": high}
    names = [p.name for p in SETPOINTS[kind].parameters()]
    values |= {"frequency": frequency} if "frequency" in names else {}
    values |= {"hold": 1.0 / frequency} if "hold" in names else {}
    return make_setpoint(kind, values)


@given(
    st.sampled_from(list(SETPOINTS)),
    st.floats(-20.0, 20.0),
    st.floats(-20.0, 160.0),
    st.floats(0.01, 100.0),
    st.sampled_from(PERIODS),
    st.lists(st.integers(0, 2999), max_size=5),
)
def test_one_sample_is_to_the_bit_what_the_array_has(
    kind: str, low: float, high: float, frequency: float, period: float, asked: list[int]
) -> None:
    signal = drawn(kind, low, high, frequency)
    samples = signal.samples(3000, period)
    assert [signal.at(k, period) for k in asked] == [samples[k] for k in asked]
    np.testing.assert_array_equal(signal.values(np.arange(1, 3000, 7), period), samples[1::7])


@given(st.sampled_from(list(SETPOINTS)), st.floats(-20.0, 20.0), st.floats(-20.0, 160.0))
def test_stays_in_its_range_and_begins_at_low(kind: str, low: float, high: float) -> None:
    samples = make_setpoint(kind, {"low": low, "high": high}).samples(12_000, 1e-3)
    slack = 1e-12 * (abs(low) + abs(high))
    assert samples[0] == pytest.approx(low, abs=slack + 1e-300)
    assert min(low, high) - slack <= samples.min() <= samples.max() <= max(low, high) + slack
    assert np.ptp(samples) == pytest.approx(abs(high - low), rel=1e-3, abs=slack)


@pytest.mark.parametrize("kind", SETPOINTS)
def test_every_parameter_says_what_it_is(kind: str) -> None:
    for parameter in SETPOINTS[kind].parameters():
        assert parameter.unit
        assert parameter.description
        assert parameter.low < parameter.high


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        ("sawtooth", {}, "reference: unknown 'sawtooth'; known are step, staircase, ramp,"),
        ("sine", {"freq": 1.0}, "reference: unknown key 'freq'; known are low, high, frequency"),
        ("sine", {"frequency": 0.0}, "reference: Sine: frequency = 0 is outside its range"),
        ("staircase", {"steps": 2.5}, "reference: Staircase: steps = 2.5 must be a whole number"),
    ],
)
def test_bad_values_give_one_line(kind: str, values: dict[str, object], message: str) -> None:
    with pytest.raises(MicrogripperError) as error:
        make_setpoint(kind, values, "reference")
    assert message in str(error.value)


def test_a_sequence_is_its_segments_one_after_the_other() -> None:
    parts = [(make_setpoint(kind, {"high": 3.0}), 0.75) for kind in SETPOINTS]
    sequence = Sequence(tuple(parts))
    expected = np.concatenate([signal.samples(750, 1e-3) for signal, _ in parts])
    samples = sequence.samples(len(expected) + 50, 1e-3)
    np.testing.assert_array_equal(samples[: len(expected)], expected)
    np.testing.assert_array_equal(samples[len(expected) :], expected[-1])
    assert sequence.boundaries(1e-3) == tuple(range(0, len(expected) + 1, 750))
    for k in (0, 749, 750, 5000, 99_999):
        assert sequence.at(k, 1e-3) == samples[min(k, len(samples) - 1)]


def test_a_sequence_of_nothing_is_refused() -> None:
    with pytest.raises(MicrogripperError, match="no segments"):
        Sequence(())
    with pytest.raises(MicrogripperError, match="segment 1: duration 0 s must be positive"):
        Sequence(((make_setpoint("sine", {}), 0.0),))
