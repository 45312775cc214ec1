"""How well each mode followed the setpoints, read from the bag alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.demo.plan import MODES, SEGMENTS, WARM_UP, course

ALIKE = 1e-12  # m: a setpoint that was recorded is the one that was planned


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

    A run begins where a setpoint comes that the one before does not merely hold.
    """
    assert recording.setpoint is not None
    setpoint = recording.setpoint
    planned = course().samples(course().boundaries(recording.sample_period)[-1], 1e-3)
    probes = np.linspace(0, len(planned) - 1, 50).astype(int)
    last = len(setpoint) - len(planned)
    for begin in range(after, last + 1):
        if abs(setpoint[begin + 1] - planned[1]) > ALIKE:
            continue
        agrees = np.abs(setpoint[begin + probes] - planned[probes]) < ALIKE
        if np.count_nonzero(agrees) > len(probes) // 2:
            return begin
    raise MicrogripperError(f"{recording.name}: the planned setpoints are not in it")


def _errors(setpoint: Array, displacement: Array) -> tuple[float, float]:
    span = float(np.ptp(setpoint))
    error = setpoint - displacement
    return float(np.sqrt(np.mean(error**2))) / span, float(np.max(np.abs(error))) / span
