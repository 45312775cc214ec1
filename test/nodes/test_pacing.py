from __future__ import annotations

from collections.abc import Iterable

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


def numbers(number: SampleNumber, ticks: Iterable[int]) -> list[int]:
    return [number.of(10**15 + tick * 1_000_000) for tick in ticks]


def test_time_that_runs_backwards_is_a_new_beginning_once_several_agree() -> None:
    number = SampleNumber(1000.0)
    assert numbers(number, (50, 51, 52, 53)) == [0, 1, 2, 3]
    # All samples of the new time count, those that were not believed at once, too.
    assert numbers(number, (3, 4, 6, 7, 8, 9, 12)) == [3, 3, 3, 3, 5, 6, 9]
    assert (number.restarts, number.disbelieved) == (1, 4)


@pytest.mark.parametrize("wild", [-3_600_000, -1000, -5, 2_000, 3_600_000])
def test_one_stamp_from_another_time_changes_nothing(wild: int) -> None:
    number = SampleNumber(1000.0)
    for tick in range(100):
        assert numbers(number, [tick, tick + wild]) == [tick, tick]
    assert number.restarts == 0


def test_a_sample_that_was_overtaken_changes_nothing() -> None:
    number = SampleNumber(1000.0)
    assert numbers(number, (0, 100, 300, 301, 303, 302, 304)) == [0, 100, 300, 301, 303, 303, 304]
    assert number.restarts == 0


def test_after_a_long_pause_time_goes_on_where_the_stamps_say() -> None:
    number = SampleNumber(1000.0)
    after = range(60_000, 60_006)
    assert numbers(number, (0, 1, *after)) == [0, 1, 1, 1, 1, 1, 60_004, 60_005]
    assert number.restarts == 0


@pytest.mark.parametrize("wild", [-3_600_000, 3_600_000])
def test_a_first_stamp_that_was_wild_sets_no_beginning(wild: int) -> None:
    number = SampleNumber(1000.0)
    assert numbers(number, (wild, *range(7))) == [0, 0, 0, 0, 0, 4, 5, 6]


def test_a_wild_stamp_that_was_believed_is_taken_back() -> None:
    """Half a second ahead may be a loss of samples."""
    number = SampleNumber(1000.0)
    assert numbers(number, (0, 1, 501, *range(2, 8))) == [0, 1, 501, 501, 501, 501, 501, 6, 7]
    assert number.restarts == 0
