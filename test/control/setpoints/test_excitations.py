"""Multisine and chirp against their spectra and frequencies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import chirp

from microgripper_control.control.setpoints import Chirp, Multisine
from microgripper_control.core.errors import MicrogripperError

T = 1e-3


@pytest.mark.parametrize("seed", [-1, 0, 7])
def test_a_multisine_has_equal_tones_in_its_band_and_none_elsewhere(seed: int) -> None:
    signal = Multisine(-1.0, 1.0, period=2.0, lowest=3.0, highest=40.0, seed=seed)
    samples = signal.samples(4000, T)
    np.testing.assert_array_equal(samples[:2000], samples[2000:])
    spectrum = np.abs(np.fft.rfft(samples[:2000]))
    band = slice(6, 81)  # harmonics of 0.5 Hz
    np.testing.assert_allclose(spectrum[band], spectrum[6], rtol=1e-9)
    outside = np.delete(spectrum[1:], np.arange(5, 80))
    assert outside.max() < 1e-9 * spectrum[6]


def test_schroeder_phases_keep_the_crest_low() -> None:
    def crest(seed: int) -> float:
        samples = Multisine(-1.0, 1.0, lowest=1.0, highest=100.0, seed=seed).samples(1000, T)
        return float(np.abs(samples - samples.mean()).max() / samples.std())

    assert crest(-1) < 1.8  # 1.41 for one sine
    assert all(crest(seed) > 2.2 for seed in range(5))


def test_seeds_give_different_signals_and_the_same_again() -> None:
    one, same, other = (Multisine(seed=seed).samples(1000, T) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.1 * np.ptp(one)


@pytest.mark.parametrize(
    ("lowest", "highest"), [(1.2, 1.8), (50.0, 40.0), (1.0, 500.0)], ids=["gap", "turned", "fast"]
)
def test_a_band_without_tones_is_refused(lowest: float, highest: float) -> None:
    signal = Multisine(lowest=lowest, highest=highest, period=1.0)
    with pytest.raises(MicrogripperError, match="must hold a harmonic of 1 Hz and end below 500"):
        signal.samples(10, T)


def test_a_chirp_agrees_with_scipy_and_goes_on_at_its_last_frequency() -> None:
    signal = Chirp(-1.0, 1.0, first=1.0, last=20.0, duration=4.0)
    time = np.arange(4000) * T
    np.testing.assert_allclose(
        signal.samples(4000, T), -chirp(time, 1.0, 4.0, 20.0, method="linear"), atol=1e-9
    )
    tail = signal.samples(6000, T)[4000:]
    np.testing.assert_allclose(tail[50:], tail[:-50], atol=1e-9)  # 20 Hz: 50 samples a cycle
    assert np.abs(np.diff(signal.samples(6000, T))).max() < 2.0 * np.pi * 20.0 * T
