"""At which rate the plant samples is told by the stamps of its samples."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.nodes.stamp_rate import ENOUGH, StampRate


def told_by(stamps: np.ndarray, rate: float) -> StampRate:
    """What stamps, s, tell to whom a rate, Hz, was said."""
    found = StampRate(rate)
    for stamp in stamps:
        found.note(round(1e9 * float(stamp)))
    return found


@pytest.mark.parametrize("rate", [100.0, 1000.0, 1300.0, 5000.0])
def test_another_rate_than_was_said_is_told(rate: float) -> None:
    found = told_by(np.arange(ENOUGH) / rate, 1000.0)
    assert found.told == pytest.approx(rate)
    assert found.is_another == (rate != 1000.0)


def test_jitter_and_missed_ticks_are_no_other_rate() -> None:
    ticks = np.delete(np.arange(200), np.arange(3, 200, 7))  # each seventh was missed
    jitter = np.random.default_rng(1).uniform(-2e-4, 2e-4, len(ticks))
    assert not told_by(1e-3 * ticks + jitter, 1000.0).is_another


@pytest.mark.parametrize("stamps", [np.arange(ENOUGH - 1) / 50.0, np.zeros(2 * ENOUGH)])
def test_few_stamps_and_those_that_stand_still_tell_nothing(stamps: np.ndarray) -> None:
    assert not told_by(stamps, 1000.0).is_another
