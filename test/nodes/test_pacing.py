from __future__ import annotations

import pytest

from microgripper_control.nodes.pacing import Pace, SampleNumber


def test_ticks_are_due_at_absolute_times() -> None:
    pace = Pace(0.001, start=100.0)
    assert pace.due(100.0) == 1
    assert pace.due(100.0009) == 0
    assert pace.wait(100.0009) == pytest.approx(0.0001)
    # Late for one, in time again for the next.
    assert pace.due(100.0019) == 1
    assert pace.due(100.002001) == 1
    assert pace.tick == 2


def test_ticks_slept_through_are_told_and_not_made_up_for() -> None:
    pace = Pace(0.001, start=0.0)
    pace.due(0.0)
    assert pace.due(0.0055) == 5
    assert pace.due(0.0055) == 0
    assert pace.wait(0.0062) == 0.0


def test_a_sample_is_numbered_by_its_stamp() -> None:
    number = SampleNumber(1000.0)
    stamps = [7_000_000_123, 7_001_000_100, 7_002_400_000, 7_010_000_000]
    assert [number.of(stamp) for stamp in stamps] == [0, 1, 2, 10]


def test_time_that_runs_backwards_is_a_new_beginning() -> None:
    number = SampleNumber(1000.0)
    assert [number.of(stamp * 1_000_000) for stamp in (50, 51, 3, 4)] == [0, 1, 0, 1]
    assert number.restarts == 1
