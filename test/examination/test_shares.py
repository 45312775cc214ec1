"""Intervals against published and hand-computed numbers."""

from __future__ import annotations

import math

import pytest

from microgripper_control.examination.shares import Middle, Share


def test_wilson_s_interval_is_the_published_one() -> None:
    # Brown, Cai and DasGupta 2001: 0 of 10 and 1 of 10 under Wilson's formula.
    assert Share(0, 10).interval == pytest.approx((0.0, 0.27754), abs=1e-4)
    assert Share(1, 10).interval == pytest.approx((0.01788, 0.40415), abs=1e-4)
    assert Share(10, 10).interval == pytest.approx((0.72246, 1.0), abs=1e-4)


def test_what_cannot_be_told_does_not_count() -> None:
    assert Share.among([True, None, False, True]) == Share(2, 3)
    assert math.isnan(Share.among([None]).value)
    assert all(math.isnan(end) for end in Share(0, 0).interval)


def test_the_median_has_the_interval_of_its_order_statistics() -> None:
    found = Middle.among([float(i) for i in range(1, 26)])
    assert found.value == 13.0
    assert (found.low, found.high) == (8.0, 18.0)  # tables of the sign test, n = 25
    assert math.isnan(Middle.among([]).value)


def test_a_median_of_fewer_than_six_has_no_interval() -> None:
    # All of n values lie on one side of the median with 2 / 2^n: 6 % for 5, 3 % for 6.
    for count in range(1, 6):
        found = Middle.among([float(i) for i in range(count)])
        assert found.value == (count - 1) / 2.0
        assert math.isnan(found.low)
        assert math.isnan(found.high)
    found = Middle.among([float(i) for i in range(6)])
    assert (found.low, found.high) == (0.0, 5.0)
