"""How well each mode followed the setpoints, and how much of that the machine missed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.demo.experiment import Run
from microgripper_control.demo.plan import SEGMENTS, WARM_UP, course

LATE = 0.01  # of a segment's span: a setpoint that far from the planned one is of another tick
MOST_MISSED = 0.25  # of a segment's ticks: with more the error says little of the controller


@dataclass(frozen=True)
class Tracking:
    """One segment of one mode: samples start .. stop of the recording, and the error in it.

    `missed` is the share of its ticks that do not count: the plant slept through them, their
    setpoint came late, or the recorder did. `rms` is None where that is more than MOST_MISSED.
    """

    mode: str
    segment: str
    start: int
    stop: int
    missed: float
    rms: float | None  # of the setpoint's peak to peak


def tracking(recording: Recording, runs: Sequence[Run]) -> list[Tracking]:
    """The tracking of each mode and segment; the warm-up does not count.

    A run of which the recording does not have the end is left out.
    """
    if recording.setpoint is None:
        raise MicrogripperError(f"{recording.name}: has no setpoint; record the topic too")
    edges = course().boundaries(recording.sample_period)
    planned = course().samples(edges[-1], recording.sample_period)
    results = []
    for run in runs:
        begin = _begin(recording, run, planned, latest=edges[2])
        if begin is None:
            continue
        for segment, start, stop in zip(SEGMENTS, edges, edges[1:], strict=False):
            if segment != WARM_UP:
                first, last = max(0, begin + start), begin + stop
                missed, rms = _error(recording, slice(first, last), planned[start:stop])
                results.append(Tracking(run.mode, segment, first, last, missed, rms))
    return results


def _begin(recording: Recording, run: Run, planned: Array, latest: int) -> int | None:
    """The sample of a run from which on the recorded setpoints are nearest to the planned.

    Where some came late the one before was held, so no threshold tells; within its run, the nearest
    is the right one. It is negative where the recorder got its first sample in the run, by the
    `latest` of it: on a machine that compiles for the first time that may be after the warm-up.
    None where the recording is too short.
    """
    assert recording.setpoint is not None
    length, period, span = len(planned), recording.sample_period, float(np.ptp(planned))
    recorded = np.concatenate([np.full(latest, np.nan), recording.setpoint])
    first = max(-latest, math.floor((run.begin - recording.start) / period))
    end = min(len(recording), math.ceil((run.end - recording.start) / period))
    apart = []
    for begin in range(first, end - length + 1):
        difference = np.abs(recorded[begin + latest :][:length] - planned)
        apart.append(np.mean(np.nan_to_num(difference, nan=span)))
    return first + int(np.argmin(apart)) if apart else None


def _error(recording: Recording, part: slice, planned: Array) -> tuple[float, float | None]:
    """The share of missed ticks in a part of the recording, and the error rms at the others.

    What was planned before the recording's first sample was missed.
    """
    assert recording.setpoint is not None
    setpoint, span = recording.setpoint[part], float(np.ptp(planned))
    recorded = planned[len(planned) - len(setpoint) :]
    counts = recording.counting[part] & (np.abs(setpoint - recorded) < LATE * span)
    missed = 1.0 - float(np.count_nonzero(counts)) / len(planned)
    if missed > MOST_MISSED:
        return missed, None
    error = (setpoint - recording.measured[part])[counts]
    return missed, float(np.sqrt(np.mean(error**2))) / span
