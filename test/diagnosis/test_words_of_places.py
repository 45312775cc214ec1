"""Where a gap lies, as people say it."""

from __future__ import annotations

import math

import pytest

from microgripper_control.diagnosis.answers.places import place, where
from microgripper_control.diagnosis.findings import Range


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (Range("direction", 0.0, 1.0, 1.0), "on rising voltage"),
        (Range("direction", -1.0, -1.0, 1.0), "on falling voltage"),
        (Range("direction", -1.0, 1.0, 1.0), "on rising and falling voltage alike"),
        (Range("hold_time_s", 0.1, 5.0, 1.0), "0.10 to 5.0 s after the voltage has come to rest"),
        (Range("hold_time_s", 0.03, 0.3, 1.0), "30 to 300 ms after the voltage has come to rest"),
        (Range("displacement_m", 1.2e-5, 1.9e-5, 1.0), "at displacements of 12 to 19 µm"),
        (Range("displacement_m", 15e-6, math.inf, 1.0), "at displacements above 15 µm"),
        (Range("voltage_V", -math.inf, 20.0, 1.0), "at voltages below 20 V"),
        (Range("rate_V_per_s", 100.0, 500.0, 1.0), "while the voltage changes by 100 to 500 V/s"),
        (Range("time_s", 1.0, 9.0, 1.0), "1.0 to 9.0 s into the recording"),
        (Range("time_s", 1.0, 9.0, 1.0, recording="b.csv"), "1.0 to 9.0 s into b.csv"),
        (Range("frequency_Hz", 49.5, 50.3, 1.0), "at frequencies of 49.5 to 50.3 Hz"),
        (Range("frequency_Hz", 12.0, 12.0, 1.0), "at frequencies of about 12 Hz"),
    ],
)
def test_places_read_as_words(found: Range, expected: str) -> None:
    assert place(found) == expected
    assert where(found) == f"100 % of the gap's power lies {expected}."


@pytest.mark.parametrize(
    ("bend", "side"), [(12e-6, "Above 12 µm"), (19e-6, "Below 19 µm")], ids=["above", "below"]
)
def test_a_bend_is_told_as_one_and_not_as_where_the_gap_is(bend: float, side: str) -> None:
    found = Range("displacement_m", 12e-6, 19e-6, 0.13, bend=bend)
    said = "the error takes another slope; 13 % of the gap's power lies there."
    assert where(found) == f"{side} {said}"
