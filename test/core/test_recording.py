"""Which samples of a recording can be held against a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording

COUNT = 1000


def recording(voltage: np.ndarray, lost: list[int], period: float = 1e-3) -> Recording:
    recorded = np.ones(len(voltage), bool)
    recorded[lost] = False
    return Recording("run", period, voltage, np.zeros(len(voltage)), recorded=recorded)


def stepped(*steps: int) -> np.ndarray:
    """A voltage that goes up by 50 V at each of some samples."""
    return 50.0 * sum((np.arange(COUNT) >= step).astype(float) for step in steps)


def test_all_of_a_recording_without_gaps_counts() -> None:
    run = Recording("run", 1e-3, stepped(500), np.zeros(COUNT))
    assert np.all(run.explained)


def test_a_gap_while_the_voltage_is_held_leaves_out_only_itself() -> None:
    run = recording(stepped(500), [300, 301])
    assert np.array_equal(np.flatnonzero(~run.explained), [300, 301])


@pytest.mark.parametrize(("period", "settling"), [(1e-3, 50), (5e-3, 10), (0.1, 5)])
def test_what_follows_a_change_at_an_unknown_moment_does_not_count(
    period: float, settling: int
) -> None:
    run = recording(stepped(500), [499, 500], period)
    assert np.array_equal(np.flatnonzero(~run.explained), np.arange(499, 501 + settling))
    assert np.array_equal(np.flatnonzero(~run.present), [499, 500])


def test_after_readings_that_do_not_count_the_rig_is_where_it_should_be() -> None:
    """Its voltage was recorded: only the readings themselves are left out."""
    read = np.ones(COUNT, bool)
    read[480:520] = False
    run = replace(recording(stepped(500), [200]), read=read)
    assert np.array_equal(np.flatnonzero(~run.explained), [200, *range(480, 520)])
    assert np.array_equal(np.flatnonzero(~run.present), [200])


def test_most_of_a_recording_with_many_gaps_still_counts() -> None:
    lost = list(range(5, COUNT - 5, 10))
    run = recording(np.linspace(0.0, 150.0, COUNT) * (-1.0) ** np.arange(COUNT), lost)
    assert np.count_nonzero(run.explained) >= 0.7 * COUNT
    assert not np.any(run.explained[lost])


def test_a_short_recording_is_not_left_out_altogether() -> None:
    assert recording(np.arange(10.0), []).unsettled() == 2


@pytest.mark.parametrize(
    "lost",
    [
        [0, 1, 500, 501],
        [500, 501, COUNT - 1],
        [0, 500, 501, COUNT - 2, COUNT - 1],
        [0, *range(10, COUNT, 7), COUNT - 1],
    ],
)
def test_a_piece_may_begin_and_end_within_a_gap(lost: list[int]) -> None:
    run = recording(stepped(500), lost)
    assert not np.any(run.explained[lost])
    assert run.explained[5]
    assert not run.explained[503 if 500 in lost else 504]
