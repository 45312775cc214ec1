"""Runs are found and errors are right, on a recording whose errors and stalls were planted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.demo.experiment import Run
from microgripper_control.demo.plan import HIGH, LOW, MODES, SAMPLE_PERIOD, SEGMENTS, course
from microgripper_control.demo.tracking import MOST_MISSED, tracking

PLANTED = {"feedforward": 0.08, "pid": 0.01, "cascade": 0.002}  # of peak to peak
COUNTED = list(SEGMENTS)[1:]
EDGES = course().boundaries(SAMPLE_PERIOD)
LENGTH = EDGES[-1]
BEFORE, BETWEEN = 700, 900  # samples, without setpoints and with the last one
BEGINS = {mode: BEFORE + index * (LENGTH + BETWEEN) for index, mode in enumerate(MODES)}
START = 1.7e9  # s since 1970
RUNS = [
    Run(
        mode,
        START + SAMPLE_PERIOD * (begin - 600),
        START + SAMPLE_PERIOD * (begin + LENGTH + 250),
    )
    for mode, begin in BEGINS.items()
]


def recording() -> Recording:
    planned = course().samples(LENGTH, SAMPLE_PERIOD)
    setpoint, displacement = [np.full(BEFORE, np.nan)], [np.zeros(BEFORE)]
    for mode in MODES:
        setpoint += [planned, np.full(BETWEEN, planned[-1])]
        displacement += [planned + PLANTED[mode] * (HIGH - LOW), np.zeros(BETWEEN)]
    wanted = np.concatenate(setpoint)
    voltage = np.zeros(len(wanted))
    measured = np.concatenate(displacement)
    return Recording("bag", SAMPLE_PERIOD, voltage, measured, wanted, start=START)


def with_late_setpoints(whole: Recording, stalls: list[tuple[int, int]]) -> Recording:
    """The reference stalled from one sample to another: its last setpoint was held."""
    assert whole.setpoint is not None
    held = whole.setpoint.copy()
    for start, stop in stalls:
        held[start:stop] = held[start - 1]
    return replace(whole, setpoint=held)


def with_missed_ticks(whole: Recording, missed: np.ndarray) -> Recording:
    """The plant slept through ticks: they were filled in, here with nonsense."""
    return replace(whole, displacement=np.where(missed, 1.0, whole.measured), read=~missed)


def test_each_mode_and_segment_has_its_planted_error() -> None:
    parts = tracking(recording(), RUNS)
    assert [(part.mode, part.segment) for part in parts] == [
        (mode, segment) for mode in MODES for segment in COUNTED
    ]
    for part in parts:
        edge = list(SEGMENTS).index(part.segment)
        assert part.start == BEGINS[part.mode] + EDGES[edge]
        assert part.stop == BEGINS[part.mode] + EDGES[edge + 1]
        assert part.missed == 0.0
        assert part.rms == pytest.approx(PLANTED[part.mode], rel=1e-6)


def test_missed_ticks_do_not_count() -> None:
    missed = np.random.default_rng(1).random(len(recording())) < 0.1
    for part in tracking(with_missed_ticks(recording(), missed), RUNS):
        assert part.missed == pytest.approx(np.mean(missed[part.start : part.stop]))
        assert part.rms == pytest.approx(PLANTED[part.mode], rel=1e-6)


def test_runs_are_found_although_the_reference_stalled() -> None:
    whole = recording()
    first, second, third = BEGINS.values()
    stalls = [
        (first, first + 300),  # without a setpoint until then
        (first + 5000, first + 6000),
        (second + 500, second + 1500),
        (second + 9000, second + 9400),
        (third + LENGTH - 700, third + LENGTH),
    ]
    parts = tracking(with_late_setpoints(whole, stalls), RUNS)
    assert [part.start for part in parts] == [part.start for part in tracking(whole, RUNS)]
    for part in parts:  # setpoints a few samples late do count
        assert part.rms == pytest.approx(PLANTED[part.mode], abs=2e-4)


def test_a_segment_that_was_mostly_missed_is_said_to_be() -> None:
    whole = recording()
    sine = BEGINS["pid"] + EDGES[COUNTED.index("sine") + 1]
    length = EDGES[-1] - EDGES[-2]
    missed = np.zeros(len(whole), bool)
    missed[sine : sine + length // 2] = True
    for stalled in (
        with_missed_ticks(whole, missed),
        with_late_setpoints(whole, [(sine, sine + length // 2)]),
        with_late_setpoints(whole, [(BEGINS["pid"], BEGINS["pid"] + LENGTH)]),
    ):
        parts = {(part.mode, part.segment): part for part in tracking(stalled, RUNS)}
        assert len(parts) == len(MODES) * len(COUNTED)
        assert parts["pid", "sine"].rms is None
        assert parts["pid", "sine"].missed > MOST_MISSED
        for mode in ("feedforward", "cascade"):
            assert parts[mode, "sine"].rms == pytest.approx(PLANTED[mode], rel=1e-6)


@pytest.mark.parametrize("seconds", [1.5, 2.14, 5.0])
def test_the_recorder_may_come_during_the_warm_up_or_later(seconds: float) -> None:
    """What of the staircase was not recorded was missed: it begins after 2 s and lasts 6.5 s."""
    whole, missing = recording(), BEFORE + round(seconds / SAMPLE_PERIOD)
    assert whole.setpoint is not None
    late = replace(
        whole,
        voltage=whole.voltage[missing:],
        displacement=whole.measured[missing:],
        setpoint=whole.setpoint[missing:],
        start=START + SAMPLE_PERIOD * missing,
    )
    first, *others = tracking(late, RUNS)
    expected = tracking(whole, RUNS)
    for part, entire in zip([first, *others], expected, strict=True):
        assert part.start == max(0, entire.start - missing)
        assert part.stop == entire.stop - missing
    assert first.missed == pytest.approx(max(0.0, seconds - 2.0) / 6.5, abs=1e-9)
    assert (first.rms is None) == (first.missed > MOST_MISSED)
    for part in others:
        assert part.missed == 0.0
        assert part.rms == pytest.approx(PLANTED[part.mode], rel=1e-6)


def test_a_run_that_was_not_recorded_is_left_out() -> None:
    whole = recording()
    cut = slice(0, BEGINS["cascade"] + 5000)
    assert whole.setpoint is not None
    short = replace(
        whole,
        voltage=whole.voltage[cut],
        displacement=whole.measured[cut],
        setpoint=whole.setpoint[cut],
    )
    assert [part.mode for part in tracking(short, RUNS)] == [
        mode for mode in MODES[:2] for _ in COUNTED
    ]
