"""The sizes of a rig at work, read off its recordings: what first guesses are measured by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.levels import grid_of
from microgripper_control.effects.base import Scales
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.plant.model import Model


def measure(model: Model, recordings: Sequence[Recording]) -> Scales:
    """The scales of recordings of the rig that `model` describes."""
    low = min(float(np.min(recording.voltage)) for recording in recordings)
    high = max(float(np.max(recording.voltage)) for recording in recordings)
    gain = model.value("bouc_wen", "d") * static_gain(model.values("second_order"))
    grid = grid_of(recordings)
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
        mass=model.value("second_order", "m"),
        resolution=grid.step,
        rounding=grid.rounding,
    )
