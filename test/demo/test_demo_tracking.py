"""Segments are found and errors are right, on a recording whose errors were planted."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.demo.plan import HIGH, LOW, MODES, SAMPLE_PERIOD, SEGMENTS, course
from microgripper_control.demo.tracking import tracking

PLANTED = {"feedforward": 0.08, "pid": 0.01, "cascade": 0.002}  # of peak to peak


def recording(modes: tuple[str, ...] = MODES) -> Recording:
    planned = course().samples(course().boundaries(SAMPLE_PERIOD)[-1], SAMPLE_PERIOD)
    setpoint, displacement = [np.full(700, np.nan)], [np.zeros(700)]
    for mode in modes:
        setpoint += [planned, np.full(900, planned[-1])]
        displacement += [planned + PLANTED[mode] * (HIGH - LOW), np.zeros(900)]
    wanted = np.concatenate(setpoint)
    voltage = np.zeros(len(wanted))
    return Recording("bag", SAMPLE_PERIOD, voltage, np.concatenate(displacement), wanted)


def test_each_mode_and_segment_has_its_planted_error() -> None:
    parts = tracking(recording())
    assert [(p.mode, p.segment) for p in parts] == [
        (mode, segment) for mode in MODES for segment in list(SEGMENTS)[1:]
    ]
    for part in parts:
        assert part.rms == pytest.approx(PLANTED[part.mode], rel=1e-6)
        assert part.largest == pytest.approx(PLANTED[part.mode], rel=1e-6)


def test_runs_are_found_although_samples_are_missing() -> None:
    whole = recording()
    assert whole.setpoint is not None
    holed = whole.setpoint.copy()
    for start in (701, 9000, 17_000, 40_000):
        holed[start : start + 300] = holed[start - 1]
    parts = tracking(Recording("bag", SAMPLE_PERIOD, whole.voltage, whole.measured, holed))
    assert [part.start for part in parts] == [part.start for part in tracking(whole)]


def test_a_run_that_is_missing_is_said_to_be() -> None:
    with pytest.raises(MicrogripperError, match="planned setpoints are not in it"):
        tracking(recording(MODES[:2]))
