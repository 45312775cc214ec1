"""The sizes of a rig at work, read off its recordings: what first guesses are measured by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Scales
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.plant.model import Model

FINEST = 1e-5  # of the stroke: steps below this are not a sensor's
ON_GRID = 0.02  # of a step: how far a reading may lie off the grid, rounding of the file included
FEWEST = 8  # distinct readings, or steps in their range; fewer tell nothing about a grid
BINS = 1 << 16  # of the range of all readings
SHARP = 0.5  # how far a comb's density follows its step, noise of a quarter of a step and less,
ALONE = 0.3  # and how far, of that, it may follow any other


def measure(model: Model, recordings: Sequence[Recording]) -> Scales:
    """The scales of recordings of the rig that `model` describes."""
    low = min(float(np.min(recording.voltage)) for recording in recordings)
    high = max(float(np.max(recording.voltage)) for recording in recordings)
    gain = model.value("bouc_wen", "d") * static_gain(model.values("second_order"))
    ends = sorted((gain * low, gain * high))
    return Scales(
        sample_period=min(recording.sample_period for recording in recordings),
        duration=max(recording.duration for recording in recordings),
        voltage=(low, high),
        rate=max(
            float(np.max(np.abs(np.diff(recording.voltage)))) / recording.sample_period
            for recording in recordings
        ),
        position=(ends[0], ends[1]),
        stiffness=model.value("second_order", "k") + model.value("second_order", "k_s"),
        resolution=max(resolution(recording.measured) for recording in recordings),
    )


def resolution(displacement: Array) -> float:
    """The step of the grid that all readings lie on or near, m; 0 if they do on none."""
    values = np.unique(displacement)
    if len(values) < FEWEST:
        return 0.0
    return _exact_step(values) or _comb_step(displacement)


def _exact_step(values: Array) -> float:
    """The step of the grid that distinct, sorted readings lie on."""
    steps = np.diff(values)
    steps = steps[steps > FINEST * np.ptp(values)]
    if len(steps) == 0 or len(steps) < 0.5 * (len(values) - 1):
        return 0.0
    step = float(np.median(steps[steps < 1.5 * np.min(steps)]))
    for _ in range(3):  # the grid's step from ever longer distances
        counts = np.rint((values - values[0]) / step)
        step = float((values - values[0]) @ counts / (counts @ counts))
    off = np.abs((values - values[0]) / step - counts)
    return step if float(np.max(off)) < ON_GRID else 0.0


def _comb_step(displacement: Array) -> float:
    """The step of a grid with noise on top, which a cable or a second converter adds.

    The readings' density is then a comb: its spectrum has one line, and that line's multiples. The
    few places at which a staircase stays give many lines.
    """
    density = np.sqrt(np.histogram(displacement, BINS)[0])
    lines = np.abs(np.fft.rfft(density))[: BINS // FEWEST] / np.sum(density)
    lines[:FEWEST] = 0.0
    steps = int(np.argmax(lines))
    line, number = lines[steps], np.arange(len(lines))
    away = np.abs(number - steps * np.rint(number / steps)) > 3.0 * np.maximum(number / steps, 1.0)
    if line < SHARP or np.max(lines[away], initial=0.0) > ALONE * line:
        return 0.0
    near = steps + np.linspace(-0.5, 0.5, 41)
    turns = np.outer(near, np.arange(BINS) / BINS)
    finer = near[np.argmax(np.abs(np.exp(2j * np.pi * turns) @ density))]
    return float(np.ptp(displacement) / finer)
