"""How well each mode followed the setpoints, read from the bag alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.demo.plan import MODES, SEGMENTS, WARM_UP, course

ALIKE = 0.1  # of the course's span: how far recorded setpoints may be from the planned, on average
NEIGHBOURHOOD = 200  # samples: about the same course, shifted
PROBES = 200  # samples of the course that are compared


@dataclass(frozen=True)
class Tracking:
    """One segment of one mode: samples start .. stop of the recording, and the error in it."""

    mode: str
    segment: str
    start: int
    stop: int
    rms: float  # of the setpoint's peak to peak
    largest: float  # of the setpoint's peak to peak


def tracking(recording: Recording) -> list[Tracking]:
    """The tracking of each mode and segment; the warm-up does not count."""
    if recording.setpoint is None:
        raise MicrogripperError(f"{recording.name}: has no setpoint; record the topic too")
    edges = course().boundaries(recording.sample_period)
    results = []
    end = 0
    for mode in MODES:
        begin = _find_course(recording, end)
        end = begin + edges[-1]
        for segment, start, stop in zip(SEGMENTS, edges, edges[1:], strict=False):
            if segment != WARM_UP:
                part = slice(begin + start, begin + stop)
                errors = _errors(recording.setpoint[part], recording.measured[part])
                results.append(Tracking(mode, segment, part.start, part.stop, *errors))
    return results


def _find_course(recording: Recording, after: int) -> int:
    """The sample at or after `after` from which on the planned setpoints were recorded.

    Where samples are missing the setpoints are held: alike means alike on the whole.
    """
    assert recording.setpoint is not None
    length = course().boundaries(recording.sample_period)[-1]
    planned = course().samples(length, recording.sample_period)
    begins = np.arange(after, len(recording) - length + 1)
    apart = np.zeros(len(begins))
    for probe in np.linspace(0, length - 1, PROBES).astype(int):
        difference = np.abs(recording.setpoint[begins + probe] - planned[probe])
        apart += np.minimum(np.nan_to_num(difference, nan=np.inf), np.ptp(planned)) / PROBES
    near = np.flatnonzero(apart < ALIKE * np.ptp(planned))
    if not len(near):
        raise MicrogripperError(f"{recording.name}: the planned setpoints are not in it")
    within = slice(near[0], near[0] + NEIGHBOURHOOD)
    return after + int(near[0] + np.argmin(apart[within]))


def _errors(setpoint: Array, displacement: Array) -> tuple[float, float]:
    span = float(np.ptp(setpoint))
    error = setpoint - displacement
    return float(np.sqrt(np.mean(error**2))) / span, float(np.max(np.abs(error))) / span
