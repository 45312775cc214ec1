"""What instruments add to a recording, taken away where that can be told from what a rig does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.quantities import quantity
from microgripper_control.core.recording import Recording
from microgripper_control.recordings.bursts import bursts
from microgripper_control.recordings.spikes import spikes
from microgripper_control.recordings.voltage_noise import voltage_noise


def cleaned(recording: Recording) -> Recording:
    """The recording without spikes, bursts and a measured voltage's noise; its warnings say so.

    One of the voltage alone is left as it is: it takes the displacement to tell.
    """
    if recording.displacement is None:
        return recording
    return _without_bursts(_without_noise(_without_spikes(recording)))


def _without_spikes(recording: Recording) -> Recording:
    """What the readings around say in the place of each spike, which does not count."""
    measured = recording.measured
    found = spikes(recording.voltage, measured)
    if not len(found):
        return recording
    others = np.delete(np.arange(len(measured)), found)
    around = np.interp(found, others, measured[others])
    farthest = np.max(np.abs(measured[found] - around))
    line = (
        f"spikes: {len(found)} single readings stand far off those around them, by up to "
        f"{quantity(float(farthest), 'm')}, the first at sample {found[0]}; they do not count"
    )
    mended = measured.copy()
    mended[found] = around
    return replace(_left_out(recording, found, line), displacement=mended)


def _without_noise(recording: Recording) -> Recording:
    """The voltage without what is noise of its own, that was never applied."""
    noise, smooth = voltage_noise(recording.voltage, recording.measured)
    if noise == 0.0:
        return recording
    line = (
        f"the voltage was recorded with noise of {quantity(noise, 'V')} rms that the displacement "
        "does not answer: it was taken away"
    )
    return replace(recording, voltage=smooth, warnings=(*recording.warnings, line))


def _without_bursts(recording: Recording) -> Recording:
    """Readings in bursts of noise do not count."""
    found = bursts(recording.voltage, recording.measured)
    if not found.any():
        return recording
    line = (
        f"bursts of noise: {np.count_nonzero(found)} readings are far louder than others in the "
        f"same place, the first at sample {np.argmax(found)}; they do not count"
    )
    return _left_out(recording, found, line)


def _left_out(
    recording: Recording, found: NDArray[np.bool_] | NDArray[np.intp], line: str
) -> Recording:
    """The recording with readings that do not count, and a line that says so."""
    read = recording.counting.copy()
    read[found] = False
    return replace(recording, read=read, warnings=(*recording.warnings, line))
