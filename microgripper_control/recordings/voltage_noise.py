"""Noise of a voltage that was recorded as measured, told from a voltage that was applied.

Every sample of noise goes there and back again, and a model's hysteresis takes that for a way which
the rig never went: where the voltage is held it relaxes, as if it crept. A jitter that was applied,
as by a controller that answers a sensor's noise, shows in the displacement; noise does not. It is
taken away by polynomials through as many samples as lie on one up to noise, around each or to
either side of it, so that steps stay where they are.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.special import chdtri

from microgripper_control.core.signals import Array
from microgripper_control.recordings.white_noise import noise_by_differences

LOOKED_AT, LONG = 256, 64  # places, and differences at each, that tell how much noise there is
QUIET = 0.25  # of the places: the voltage moves least there
WHITE = 1.4  # how far noise told by third differences may be off that told by fifth ones
LENGTHS = (65, 33, 17, 9, 5)  # samples that may lie on one polynomial
AROUND, BESIDE = 2, 1  # orders of those around a sample, and to either side of it
LARGEST = 0.005  # of the voltage's span: what is more was meant
BLOCK = 1 << 16  # samples at once; so many tell whether a jitter was applied as well
LIKELY = 0.99  # of the polynomials through noise alone are no further off
MORE_WAY = 0.002  # that noise adds to the way of the voltage: less does no harm
LAGS = 10  # samples within which a rig answers a voltage, or a controller the rig
CALM = 3.0  # times the noise: the voltage goes straight on where it bends by less, as it must for
MOST = 0.5  # of the samples
TOLD, SURE = 0.02, 3.0  # of a jitter's power, and times what chance tells: if readings tell more


@np.errstate(all="ignore")  # what a damaged file holds may overflow
def voltage_noise(voltage: Array, displacement: Array) -> tuple[float, Array]:
    """The noise of a voltage, V rms, and the voltage without it, shape (n,).

    0 and the voltage as it is where there is none, or where the displacement, m, shape (n,), tells
    of it or might: it was applied then.
    """
    noise = _white_noise(voltage)
    if not 0.0 < noise < LARGEST * float(np.ptp(voltage)):
        return 0.0, voltage
    smooth = _smoothed(voltage, noise)
    if _way(voltage) < (1.0 + MORE_WAY) * _way(smooth):
        return 0.0, voltage
    if _may_belong(voltage[:BLOCK], smooth[:BLOCK], displacement[:BLOCK], noise):
        return 0.0, voltage
    return noise, smooth


def _way(voltage: Array) -> float:
    return float(np.sum(np.abs(np.diff(voltage))))


def _white_noise(voltage: Array) -> float:
    """The white noise, V rms, where the voltage moves least; 0 if what is there is not white."""
    if len(voltage) < 2 * LONG:
        return 0.0
    first = np.unique(np.linspace(0, len(voltage) - LONG - 5, LOOKED_AT).astype(int))
    places = voltage[first[:, None] + np.arange(LONG + 5)]
    third, fifth = (noise_by_differences(places, order) for order in (3, 5))
    at = int(np.argsort(fifth)[int(QUIET * len(first))])
    if fifth[at] == 0.0 or not 1.0 / WHITE < np.median(third / fifth.clip(1e-300)) < WHITE:
        return 0.0
    return float(np.median(fifth[fifth <= fifth[at] * WHITE]))


def _smoothed(voltage: Array, noise: float) -> Array:
    """`_on_longest` in blocks, as the windows take some memory."""
    margin, smooth = LENGTHS[0], np.empty_like(voltage)
    for start in range(0, len(voltage), BLOCK):
        first = max(0, start - margin)
        near = _on_longest(voltage[first : start + BLOCK + margin], noise)
        smooth[start : start + BLOCK] = near[start - first : start - first + BLOCK]
    return smooth


def _on_longest(voltage: Array, noise: float) -> Array:
    """The voltage on the longest polynomials that it lies on up to noise; else as it is."""
    smooth: Array = voltage.copy()
    done = np.zeros(len(voltage), bool)
    for length in LENGTHS:
        if length > len(voltage):
            continue
        windows = sliding_window_view(voltage, length)
        for samples, values in _on_polynomials(windows, noise):
            free = ~done[samples]
            smooth[samples[free]] = values[free]
            done[samples[free]] = True
    return smooth


def _on_polynomials(windows: Array, noise: float) -> Iterator[tuple[NDArray[np.intp], Array]]:
    """Samples and their values, V, on polynomials through as many as lie in a window."""
    length = windows.shape[1]
    for order, places in ((AROUND, [length // 2]), (BESIDE, [length - 1, 0])):
        basis: Array = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), order + 1))[0]
        off = windows - (windows @ basis) @ basis.T
        freedom = length - order - 1
        limit = noise**2 * float(chdtri(freedom, 1.0 - LIKELY))
        near = np.flatnonzero(np.einsum("ij,ij->i", off, off) <= limit)
        for place in places:
            yield near + place, windows[near] @ (basis @ basis[place])


def _may_belong(voltage: Array, smooth: Array, displacement: Array, noise: float) -> bool:
    """Whether readings shortly before or after tell of a jitter of the voltage, or might.

    Only where the voltage goes on as it did: elsewhere what it does to the displacement hides that.
    """
    cause, answers = np.diff(voltage, 3), np.diff(displacement, 3)
    bends = np.abs(np.diff(smooth, 2))[:-1]
    calm = sliding_window_view(bends, 2 * LAGS).max(axis=1) < CALM * noise
    near = sliding_window_view(answers, 2 * LAGS)[calm]
    jitter = cause[LAGS : LAGS + len(calm)][calm]
    if len(jitter) < MOST * len(voltage):
        return True
    weights = np.linalg.pinv(near.T @ near, hermitian=True) @ (near.T @ jitter)
    told = float(jitter @ (near @ weights)) / max(float(jitter @ jitter), 1e-300)
    return not told <= TOLD + SURE * 2 * LAGS / len(jitter)
