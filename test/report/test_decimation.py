"""Shortened signals keep their extremes, and packed ones their values."""

from __future__ import annotations

import numpy as np
import pytest
from packed_values import unpacked

from microgripper_control.report.decimation import LEVELS, extremes, packed, path


def test_a_spike_of_one_sample_stays() -> None:
    signal = np.sin(np.linspace(0.0, 9.0, 100_003))
    signal[54_321] = 7.0
    drawn = extremes(signal, 500)
    assert len(drawn) == 1000
    assert (np.max(drawn), np.min(drawn)) == (7.0, np.min(signal))


def test_each_bucket_gives_its_extremes_in_the_order_in_which_they_come() -> None:
    drawn = extremes(np.array([1.0, 5.0, 2.0, 9.0, 3.0, 0.0]), 2)
    assert drawn.tolist() == [1.0, 5.0, 9.0, 0.0]


def test_a_short_signal_is_left_as_it_is() -> None:
    signal = np.arange(10.0)
    assert extremes(signal, 5) is signal
    assert path([signal, signal], 5).tolist() == list(range(10))


def test_a_path_keeps_both_ends_and_the_extremes_of_either_signal() -> None:
    rng = np.random.default_rng(1)
    voltage, displacement = rng.standard_normal((2, 5000))
    kept = path([voltage, displacement], 50)
    assert len(kept) <= 202
    assert np.all(np.diff(kept) > 0)
    ends = {int(f(s)) for s in (voltage, displacement) for f in (np.argmin, np.argmax)}
    assert {0, 4999} | ends <= set(kept.tolist())


@pytest.mark.parametrize("logarithmic", [False, True])
def test_packed_values_come_back(logarithmic: bool) -> None:
    values = np.geomspace(1e-3, 1e4, 999)
    found = unpacked(packed(values, logarithmic))
    tolerance = 0.51 * (7.0 * np.log(10.0) if logarithmic else 1e4) / LEVELS
    error = np.abs(found - values) / (values if logarithmic else 1.0)
    assert np.max(error) < tolerance


def test_a_constant_is_packed() -> None:
    assert unpacked(packed(np.full(3, 2.5))).tolist() == [2.5] * 3
