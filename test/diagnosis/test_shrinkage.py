"""The interval of the share that is closed: wide where little is known, not where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.diagnosis.answers.shrinkage import closed_interval

NOISE = 10e-9


@pytest.mark.parametrize("blocks", [1, 2, 3, 20])
def test_draws_without_a_gap_do_not_count_as_not_closed(blocks: int) -> None:
    """Of 40 blocks a contact is touched in some, and the law takes away 99 % everywhere."""
    gap = np.zeros(20_000)
    wave = 500e-9 * np.sin(np.arange(500) / 20.0)
    for block in range(blocks):
        gap[1000 * block : 1000 * block + 500] = wave
    white = np.random.default_rng(0).standard_normal(len(gap))
    noise = NOISE * white / np.sqrt(np.mean(white**2))
    low, high = closed_interval([gap + noise], [0.01 * gap + noise], NOISE)
    assert 0.9 < low < high <= 1.0


def test_a_gap_that_a_law_closes_in_some_blocks_alone_leaves_a_wide_interval() -> None:
    rng = np.random.default_rng(1)
    gap = 100e-9 * np.sin(np.arange(20_000) / 30.0)
    noise = NOISE * rng.standard_normal(len(gap))
    left = np.where(np.arange(len(gap)) // 500 % 4 == 0, 1.0, 0.05) * gap
    low, high = closed_interval([gap + noise], [left + noise], NOISE)
    assert low < 0.5 < high < 0.8
    assert high - low > 0.1


def test_without_a_gap_nothing_is_closed() -> None:
    quiet = [np.full(4000, 1e-9)]
    assert closed_interval(quiet, quiet, NOISE) == (0.0, 0.0)
