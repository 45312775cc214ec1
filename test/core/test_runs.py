"""Samples in a row."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.runs import runs


@pytest.mark.parametrize("shortest", [1, 2, 3])
def test_runs_are_all_the_stretches_that_are_long_enough(shortest: int) -> None:
    mask = np.array([1, 1, 0, 1, 0, 0, 1, 1, 1], bool)
    stretches = [slice(0, 2), slice(3, 4), slice(6, 9)]
    assert runs(mask, shortest) == [s for s in stretches if s.stop - s.start >= shortest]


@pytest.mark.parametrize("mask", [[], [0, 0]])
def test_where_nothing_is_so_there_is_no_run(mask: list[int]) -> None:
    assert runs(np.array(mask, bool)) == []
