"""Numbers as people read them."""

from __future__ import annotations

import math

import pytest

from microgripper_control.core.quantities import number, percent, quantity, span


@pytest.mark.parametrize(
    ("value", "digits", "expected"),
    [
        (0.0, 2, "0"),
        (24873.0, 2, "25000"),
        (148.2, 3, "148"),
        (0.01234, 2, "0.012"),
        (-9.96, 2, "-10"),
        (0.996, 2, "1.0"),
        (math.inf, 2, "inf"),
    ],
)
def test_a_number_keeps_its_significant_digits(value: float, digits: int, expected: str) -> None:
    assert number(value, digits) == expected


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        (8.5e-8, "m", "85 nm"),
        (9.996e-7, "m", "1.0 µm"),
        (1e-6, "m", "1.0 µm"),
        (-1e-3, "V", "-1.0 mV"),
        (2400.0, "s", "2400 s"),
        (0.1, "Hz", "0.10 Hz"),
        (2500.0, "Hz", "2.5 kHz"),
        (5e4, "N/m", "50 kN/m"),
        (0.02, "kg", "0.020 kg"),
        (0.0, "m", "0 m"),
        (0.012, "1", "0.012"),
    ],
)
def test_a_quantity_takes_the_prefix_in_which_it_reads_best(
    value: float, unit: str, expected: str
) -> None:
    assert quantity(value, unit) == expected


@pytest.mark.parametrize(
    ("low", "high", "unit", "expected"),
    [
        (9e-9, 1.2e-7, "m", "9.0 to 120 nm"),
        (49.5, 50.3, "Hz", "49.5 to 50.3 Hz"),
        (929.99999999, 930.0, "V/s", "about 930 V/s"),
        (0.0, 0.2, "Hz", "0 to 0.20 Hz"),
        (-5.0, 5.0, "V", "-5.0 to 5.0 V"),
        (31.0, math.inf, "s", "above 31 s"),
        (-math.inf, 0.5, "s", "below 500 ms"),
        (1.0, 2.5, "kg", "1.0 to 2.5 kg"),
        (0.01, 0.02, "1", "0.010 to 0.020"),
        (0.5, math.inf, "1", "above 0.50"),
    ],
)
def test_a_range_has_one_unit_and_says_where_it_is_open(
    low: float, high: float, unit: str, expected: str
) -> None:
    assert span(low, high, unit) == expected


def test_a_share_is_a_percentage() -> None:
    assert percent(0.0123) == "1.2 %"
