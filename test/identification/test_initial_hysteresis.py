"""The h that leaves the least squares is found wherever in its range it lies."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.identification.initial_hysteresis import least_squares_h

LEFT = {
    "straight": lambda h: (h - 0.37, 0.1),
    "two basins": lambda h: (abs(h) - 0.6, 0.2 * (h - 0.5)),
    "a kink": lambda h: (abs(h - 0.11) + 0.3, 0.1 * h),
    "bent": lambda h: (np.exp(3.0 * h) - 2.0, 0.5 * h),
    "bent the other way, little left": lambda h: (np.log(h + 1.2) + 0.3, 1e-6),
    "least beyond the bound": lambda h: (h - 3.0, 0.1),
    "diverges on one side": lambda h: (h - 0.2 if h > -0.3 else np.inf, 0.1),
}


@pytest.mark.parametrize("what", LEFT)
def test_the_initial_hysteresis_leaves_the_least_of_its_range(what: str) -> None:
    tried: list[float] = []

    def squares(h: float) -> float:
        return float(np.sum(np.square(LEFT[what](h))))

    def left(h: float) -> Array:
        tried.append(h)
        return np.array(LEFT[what](h))

    h = least_squares_h(left, 1.0)
    assert max(map(abs, tried)) <= 1.0
    assert squares(h) <= 1.000001 * min(map(squares, tried))
    assert squares(h) < 1.01 * min(map(squares, np.linspace(-1.0, 1.0, 2001)))


def test_an_initial_hysteresis_that_does_not_matter_is_zero() -> None:
    assert least_squares_h(lambda h: np.array([1.0, 2.0]), 1.0) == 0.0
