"""Fit-free tests: what each effect would leave in a residual, and whether it is there.

A fit asks how well a law can imitate the residual; a signature asks for something that only this
effect, or its kin, would leave. `agrees` is False only where the recordings would show the thing
clearly and do not; one that is hidden behind a larger effect is no contradiction, but None.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from microgripper_control.core.quantities import percent, quantity, span
from microgripper_control.diagnosis.data.evidence import rms
from microgripper_control.diagnosis.data.grid import NO_GRID, Grid, matters, refuted
from microgripper_control.diagnosis.data.levels import grid_of
from microgripper_control.diagnosis.data.residuals import Residual, gap_power
from microgripper_control.diagnosis.findings import Signature
from microgripper_control.diagnosis.signs.bands import find_peaks, resonances, slow_share
from microgripper_control.diagnosis.signs.motion_signatures import (
    REAL,
    creep,
    lateness_of,
    play,
    rate_dependent_hysteresis,
    slew_limit,
    thresholds,
)
from microgripper_control.diagnosis.signs.spectra import Spectrum, same_clock, spectrum_of

MAINS = (50.0, 60.0)  # Hz
NEAR = 0.6  # Hz: how far the mains may be off
STANDS_OUT = 0.1  # of the gap: what a resonance holds at least

Test = Callable[[Sequence[Residual], float], list[Signature]]


def signatures(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """What fit-free tests say of each effect that has one, on residuals of the refitted model.

    `noise` is the standard deviation of the white noise, m.
    """
    return [signature for test in TESTS for signature in test(residuals, noise)]


def mains_hum(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """A line at the mains frequency that the motion does not have."""
    spectra = [spectrum_of(group) for group in same_clock(residuals)]
    seen = [s for s in spectra if s is not None and s.frequency[-1] > 1.1 * MAINS[1]]
    if not seen:
        return [Signature("mains_hum", None, "Sampled too slowly to see 50 or 60 Hz.")]
    spectrum = max(seen, key=lambda s: s.stretches / s.resolution)
    for peak in find_peaks(spectrum, noise):
        if peak.line and any(abs(peak.frequency - mains) < NEAR for mains in MAINS):
            size = quantity(np.sqrt(2.0 * peak.power), "m")
            return [
                Signature(
                    "mains_hum",
                    True,
                    f"A line at {peak.frequency:.2f} Hz of {size} amplitude stands "
                    f"{peak.contrast:.0f} times above its neighbours and not in the motion.",
                )
            ]
    heights = [_height(spectrum, mains) for mains in MAINS]
    moving = any(_moving(spectrum, mains, noise) for mains in MAINS)
    limit = quantity(np.sqrt(2.0 * max(h[1] for h in heights)), "m")
    agrees = None if moving or max(h[0] for h in heights) > 4.0 else False
    return [
        Signature(
            "mains_hum",
            agrees,
            f"No line stands out at 50 or 60 Hz: what is there is below {limit}.",
        )
    ]


def _height(spectrum: Spectrum, frequency: float) -> tuple[float, float]:
    """Density near a frequency over that around it, and the power there, m^2."""
    off = np.abs(spectrum.frequency - frequency)
    near = off < max(NEAR, spectrum.resolution)
    around = (off < 10.0 * spectrum.resolution) & ~near
    level = float(np.median(spectrum.error[around])) if around.any() else 0.0
    height = float(np.max(spectrum.error[near]))
    return height / max(level, 1e-300), height * spectrum.resolution


def _moving(spectrum: Spectrum, frequency: float, noise: float) -> bool:
    """Whether the motion itself is large at a frequency, so that a line would be hidden."""
    near = np.abs(spectrum.frequency - frequency) < max(NEAR, spectrum.resolution)
    return bool(np.max(spectrum.motion[near]) > 20.0 * noise**2 * spectrum.period)


def sensor_quantization(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """Readings that repeat, on a grid."""
    readings = [residual.recording.measured for residual in residuals]
    grid = grid_of([residual.recording for residual in residuals])
    error = rms([residual.error[residual.counted] for residual in residuals])
    if refuted(grid, error, readings):
        grid = NO_GRID
    distinct = min(len(np.unique(one)) / len(one) for one in readings)
    usual = max(float(np.median(np.diff(np.unique(one)))) for one in readings)
    levels = grid if grid != NO_GRID else Grid.even(usual)
    size, rounded, floor = (quantity(length, "m") for length in (*levels, noise))
    text = f"steps of {size}, {rounded} rms, with {floor} noise"
    if distinct > 0.5 and grid == NO_GRID:
        text = f"{percent(distinct)} of the readings differ, on no grid: no converter rounds them."
        return [Signature("sensor_quantization", False, text)]
    if matters(levels, noise):
        kind = "a grid" if grid != NO_GRID else "levels that repeat"
        text = f"The readings lie on {kind}: {text}."
        return [Signature("sensor_quantization", True, text)]
    if levels.rounding < 0.05 * noise:
        text = f"The readings' {text}, are far too fine to matter."
        return [Signature("sensor_quantization", False, text)]
    return [Signature("sensor_quantization", None, f"The readings' {text}, hardly matter.")]


def thermal_drift(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """Slow error that is no function of the voltage."""
    if gap_power(residuals, noise) <= REAL * noise**2:
        return [Signature("thermal_drift", None, "There is no gap to look at.")]
    share = slow_share(residuals, noise)
    text = (
        f"{percent(share)} of the gap is slower than 0.2 Hz and does not repeat with the voltage."
    )
    return [Signature("thermal_drift", True if share > 0.5 else None, text)]


def extra_resonance(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """A peak of the residual that is no line and that the motion alone does not explain."""
    found = [peak for group in same_clock(residuals) for peak in resonances(group, noise)]
    if not found:
        text = "No peak broader than a line stands out of the residual's spectrum."
        return [Signature("extra_resonance", None, text)]
    peak = max(found, key=lambda one: one.power)
    total = gap_power(residuals, noise)
    share = peak.power / max(total, peak.power)
    text = (
        f"The residual's spectrum has a peak at {quantity(peak.frequency, 'Hz')}, from "
        f"{span(peak.low, peak.high, 'Hz')}, with {percent(share)} of the gap."
    )
    return [Signature("extra_resonance", True if peak.power > STANDS_OUT * total else None, text)]


TESTS: tuple[Test, ...] = (
    lateness_of,
    slew_limit,
    thresholds,
    creep,
    rate_dependent_hysteresis,
    play,
    extra_resonance,
    sensor_quantization,
    thermal_drift,
    mains_hum,
)
