"""What a grid does to readings on it: a sensor or converter shows levels, not positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.identification.levels import OFTEN

BOWED = 0.15  # of a step, rms: what a real converter's grid is off the one it is taken for
A_STEP = 1.2  # values, if they are no more than a grid has
TOO_CLOSE = 0.8  # of what rounding leaves: readings that follow a model closer are on no such grid
MATTERS = 0.75  # of the noise: with rounding that leaves more a reading is off by a quarter more


class Grid(NamedTuple):
    """The levels of a sensor: the usual step between them, m, and what rounding leaves, m rms."""

    step: float
    rounding: float

    @classmethod
    def even(cls, step: float) -> Grid:
        """Levels that are all a step, m, apart."""
        return cls(step, step / float(np.sqrt(12.0)))


NO_GRID = Grid(0.0, 0.0)


def unrounded(error: float, grid: Grid) -> float:
    """What is left of an error, m rms, without what a grid, bowed or not, adds."""
    return float(np.sqrt(max(error**2 - grid.rounding**2 - (BOWED * grid.step) ** 2, 0.0)))


def noise_under(floor: float, grid: Grid) -> float:
    """The noise, m rms, of a sensor whose readings have an innovation, m, and lie on a grid.

    Rounding looks like noise, but it is the grid's doing. Below the bow nothing can be told.
    """
    return min(floor, max(unrounded(floor, grid), BOWED * grid.step))


def matters(grid: Grid, noise: float) -> bool:
    """Whether rounding keeps readings much further from any model than their noise, m rms, does."""
    return grid.rounding > MATTERS * noise


def refuted(grid: Grid, error: float, readings: Sequence[Array]) -> bool:
    """Whether readings that follow some model with an error, m rms, cannot lie on a grid.

    A comb of positions can be the excitation's: a staircase of equal steps has one as well. Where
    the readings are no more values than the grid has, it is theirs, however close a model comes: at
    a few levels a flexible one follows the rounding itself.
    """
    close = error < TOO_CLOSE * grid.rounding
    return close and not all(_rounded(one, grid.step) for one in readings)


def _rounded(displacement: Array, step: float) -> bool:
    """Whether there is hardly more than one value for each step, m, and that is read often."""
    values = len(np.unique(displacement))
    return values < min(A_STEP * (np.ptp(displacement) / step + 1.0), len(displacement) / OFTEN)
