from __future__ import annotations

from collections.abc import Sequence as Row

import pytest
from bag_messages import JOINT_STATE, STORE, joint_state

from microgripper_control.recordings.losses import (
    MOST_DRIVERS,
    JointStates,
    Sequence,
    StampedSamples,
)

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


def serialized(tick: int, names: Row[str] = ("finger",)) -> bytes:
    values = [0.1 * tick] * len(names)
    sent = joint_state(tick * MILLISECOND, values, values, names=names)
    return bytes(STORE.serialize_cdr(sent.message, JOINT_STATE))


@pytest.mark.parametrize("other", [["stage"], ["stage", "finger"], []])
def test_of_drivers_that_share_a_topic_each_has_a_clock_of_its_own(other: list[str]) -> None:
    states = JointStates()
    for tick in range(500):
        if tick not in (300, 301):
            states.note(serialized(tick))
        if tick % 4 == 1 and tick != 401:
            states.note(serialized(tick, other))
    assert states.missing == 3


def test_a_message_that_is_cut_off_is_no_sample() -> None:
    whole, states = serialized(5), JointStates()
    states.note(whole)
    for length in range(27):
        states.note(whole[:length])
    assert states.missing == 0


def test_names_that_never_end_do_not_fill_the_memory() -> None:
    states = JointStates()
    for tick in range(500):
        states.note(serialized(tick, [f"joint_{tick}"]))
    assert len(states._drivers) <= MOST_DRIVERS + 1
