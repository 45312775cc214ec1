"""Numbers, units and places as people write them."""

from __future__ import annotations

import math

import pytest

from microgripper_control.report.wording import (
    number,
    percent,
    quantity,
    span,
    unbroken,
    written,
)


def plain_spaces(text: str) -> str:
    return text.replace("\u00a0", " ").replace("\u202f", " ")


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (0.0, 3, "0"),
        (0.0996, 2, "0.10"),
        (9.996, 3, "10.0"),
        (23383.0, 2, "23 000"),
        (-1234.0, 4, "\u22121234"),
        (1.4447e-7, 4, "1.445 \u00d7 10⁻⁷"),
        (math.inf, 3, "∞"),
        (math.nan, 3, "\u2013"),
    ],
)
def test_number(value: float, digits: int, text: str) -> None:
    assert plain_spaces(number(value, digits)) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.5e-8, "m", "15.0 nm"),
        (1e-6, "m", "1.00 µm"),
        (0.0, "m", "0 m"),
        (0.0021, "s", "2.10 ms"),
        (3600.0, "s", "3600 s"),
        (8.2e5, "N/m", "820 kN/m"),
        (0.0801, "1", "0.0801"),
        (2e10, "N/m^2", "2.00 \u00d7 10¹⁰ N/m²"),
    ],
)
def test_quantity(value: float, unit: str, text: str) -> None:
    assert plain_spaces(quantity(value, unit)) == text


def test_a_range_has_one_unit_and_says_where_it_is_open() -> None:
    assert plain_spaces(span(9e-9, 1.2e-7, "m", 2)) == "9.0 to 120 nm"
    assert plain_spaces(span(31.0, math.inf, "s", 2)) == "more than 31 s"
    assert plain_spaces(span(-math.inf, 0.5, "s", 2)) == "less than 500 ms"
    assert span(-math.inf, math.inf, "s") == "not determined"
    assert plain_spaces(span(-1100.4, -1099.8, "1/m", 2)) == "\u22121100.4 to \u22121099.8 1/m"
    assert plain_spaces(span(1.23401, 1.23402, "", 2)) == "1.23401 to 1.23402"
    assert plain_spaces(span(464.6, 464.6, "V/s", 2)) == "about 460 V/s"


def test_a_share_that_is_not_quite_nothing_or_all_says_so() -> None:
    shares = (0.0, -3e-7, 0.001, 0.5, 0.999, 1.0, math.nan)
    texts = ["0 %", "0 %", "< 1 %", "50 %", "> 99 %", "100 %", "\u2013"]
    assert [plain_spaces(percent(share)) for share in shares] == texts


def test_units_are_written_as_people_do() -> None:
    assert written("1/(V*m^(n-1))") == "1/(V·mⁿ⁻¹)"
    assert written("N/m^3") == "N/m³"


def test_numbers_stay_with_their_units_and_intervals_in_one_piece() -> None:
    text = "from 69 nm to 17 nm in 3 steps: 88 % [84, 91] of it"
    assert unbroken(text).count("\u00a0") == 4
