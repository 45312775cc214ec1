"""Long signals made short for drawing, and packed for a page.

A line on a screen shows, in each column of pixels, the span from the lowest to the highest sample
in it. So of each bucket of samples the extremes are kept, never every so manieth sample: a spike of
one sample stays in sight.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array

LEVELS = 65535  # of 16 bits: a thousandth of a pixel


def _edges(length: int, buckets: int) -> NDArray[np.int64]:
    """Where the buckets begin, shape (buckets,)."""
    edges: NDArray[np.int64] = np.arange(buckets, dtype=np.int64) * length // buckets
    return edges


def extremes(signal: Array, buckets: int) -> Array:
    """Lowest and highest sample of each bucket in the order in which they come, (2 buckets,).

    A signal of no more samples than that is returned as it is.
    """
    if len(signal) <= 2 * buckets:
        return signal
    chosen = _extreme_indices(signal, buckets)
    chosen.sort(axis=1)
    shortened: Array = signal[chosen.ravel()]
    return shortened


def path(signals: Sequence[Array], buckets: int) -> NDArray[np.int64]:
    """Indices of the samples at which any of the signals has an extreme of its bucket.

    For lines of one signal over another, whose corners are extremes of either.
    """
    length = len(signals[0])
    if length <= 2 * buckets * len(signals):
        return np.arange(length, dtype=np.int64)
    ends = np.array([0, length - 1], dtype=np.int64)
    return np.unique(
        np.concatenate([ends, *(_extreme_indices(s, buckets).ravel() for s in signals)])
    )


def _extreme_indices(signal: Array, buckets: int) -> NDArray[np.int64]:
    """Index of the lowest and of the highest sample of each bucket, shape (buckets, 2)."""
    starts = _edges(len(signal), buckets)
    ends = np.append(starts[1:], len(signal))
    found = [
        (a + int(np.argmin(signal[a:b])), a + int(np.argmax(signal[a:b])))
        for a, b in zip(starts.tolist(), ends.tolist(), strict=True)
    ]
    return np.array(found, dtype=np.int64)


def packed(values: Array, logarithmic: bool = False) -> dict[str, object]:
    """Values in 16 bits each: `low` + number x `step`, of their logarithm if `logarithmic`."""
    scale = np.log10(values) if logarithmic else values
    low = float(np.min(scale))
    step = (float(np.max(scale)) - low) / LEVELS
    levels = np.zeros(len(scale)) if step == 0.0 else np.rint((scale - low) / step)
    raw = levels.clip(0, LEVELS).astype("<u2").tobytes()
    code = base64.b64encode(raw).decode()
    return {"low": low, "step": step, "log": logarithmic, "base64": code}
