"""Slow random courses, the same whatever grid they are read on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import butter, sosfilt

from microgripper_control.validation.block import Array


def slow_course(
    generator: np.random.Generator, begin: float, end: float, corner: float
) -> Callable[[Array], Array]:
    """Gaussian noise of unit variance below `corner` (Hz), as a function of the time in s.

    White noise through a second-order low-pass, on a grid of 20 points a corner period that is
    joined by straight lines; it is stationary from `begin` on.
    """
    spacing = 0.05 / corner
    settling = 200
    times = begin + spacing * np.arange(int((end - begin) / spacing) + 3)
    white = generator.standard_normal(len(times) + settling)
    values = sosfilt(butter(2, 0.1, output="sos"), white)[settling:]
    values /= 0.3313  # its standard deviation

    def course(at: Array) -> Array:
        values_there: Array = np.interp(at, times, values)
        return values_there

    return course
