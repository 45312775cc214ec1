from __future__ import annotations

import pytest

from microgripper_control.recordings.losses import Sequence, StampedSamples

MILLISECOND = 1_000_000  # ns


def test_numbers_that_are_skipped_are_lost_messages() -> None:
    sequence = Sequence()
    for number in (5, 6, 9, 10):
        sequence.note(number)
    assert (sequence.count, sequence.lost) == (4, 2)


def test_another_publisher_is_no_loss() -> None:
    sequence = Sequence()
    for number in (5, 6, 1, 2):
        sequence.note(number)
    assert sequence.lost == 0


def test_gaps_between_stamps_are_counted_in_a_short_recording_and_a_long_one() -> None:
    for length in (20, 1000):
        samples = StampedSamples()
        for tick in range(length):
            if tick not in (3, 10, 11, length - 2):
                jitter = 100_000 * (tick % 3)
                samples.note(7_000_000_000 + tick * MILLISECOND + jitter)
        assert samples.missing == 4, length
        assert samples.count == length - 4


def test_time_that_runs_backwards_is_no_gap() -> None:
    samples = StampedSamples()
    for tick in (*range(500), *range(500)):
        samples.note(tick * MILLISECOND)
    assert samples.missing == 0


@pytest.mark.parametrize("first", [0, 50_000])
def test_two_publishers_by_turns_lose_nothing(first: int) -> None:
    sequence = Sequence()
    for number in range(1, 100):
        sequence.note(first + number)
        sequence.note(50_000 - first + number)
    assert (sequence.count, sequence.lost) == (198, 0)
    sequence.note(50_105)
    sequence.note(100)
    assert sequence.lost == 5
