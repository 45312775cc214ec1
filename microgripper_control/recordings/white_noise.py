"""White noise told by differences: of an order high enough hardly anything smooth is left."""

from __future__ import annotations

import numpy as np
from scipy.special import binom

from microgripper_control.core.signals import Array

BLOCK = 2048  # windows at once: more would not stay near the processor


def noise_by_differences(windows: Array, order: int) -> Array:
    """The noise, rms, of each of some windows, shape (count, samples), if all of it is white.

    Differences of an order n have binom(2 n, n) times the power of white noise.
    """
    found = np.empty(len(windows))
    for first in range(0, len(windows), BLOCK):
        block = slice(first, first + BLOCK)
        differences = np.diff(windows[block], order, axis=1)
        found[block] = np.einsum("ij,ij->i", differences, differences)
    noise: Array = np.sqrt(found / ((windows.shape[1] - order) * binom(2 * order, order)))
    return noise
