"""A recording is cut where nobody knows what was applied, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.gaps import cut_at_gaps
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.simulate import Initial
from microgripper_control.recordings.clock import on_uniform_clock
from microgripper_control.recordings.samples import Samples

PERIOD, COUNT = 1e-3, 6000  # s, samples
TIME = PERIOD * np.arange(COUNT)
VOLTAGE = 80.0 + 60.0 * np.sin(2.0 * np.pi * 0.8 * TIME)
AT_REST = Conditions(initial=Initial.REST)


def without(first: int, last: int) -> Recording:
    """A recording of which the samples from one to before another are missing."""
    there = np.r_[:first, last:COUNT]
    noise = 1e-8 * np.random.default_rng(1).standard_normal(COUNT)
    samples = Samples(TIME[there], VOLTAGE[there], (1.4e-7 * VOLTAGE + noise)[there], None, 5.0)
    return on_uniform_clock("run.csv", samples)


def test_after_a_long_gap_a_recording_begins_anew() -> None:
    found = cut_at_gaps([without(2000, 3500)], [], AT_REST)
    before, after = found.recordings
    assert (before.name, after.name) == ("run.csv", "run.csv from 3.5 s")
    assert np.array_equal(before.voltage, VOLTAGE[:2000])
    assert np.array_equal(after.voltage, VOLTAGE[3500:])
    assert after.start == pytest.approx(8.5)
    assert before.present.all()
    assert after.present.all()
    assert found.conditions.initial is Initial.FIRST_SAMPLE
    (line,) = found.lines
    assert line.startswith("run.csv: nobody knows what was applied")


def test_a_part_that_rests_between_two_gaps_is_left_out() -> None:
    whole = without(0, 0)
    voltage = np.where((TIME >= 3.0) & (TIME < 3.9), 0.0, VOLTAGE)
    present = ~(((TIME >= 2.0) & (TIME < 3.0)) | ((TIME >= 3.9) & (TIME < 4.9)))
    resting = replace(whole, voltage=voltage, recorded=present)
    found = cut_at_gaps([resting], [], AT_REST)
    assert [len(one) for one in found.recordings] == [2000, 1100]
    assert all(one.part for one in found.recordings)
    assert not whole.part


def test_held_out_recordings_are_cut_as_well() -> None:
    whole = without(0, 0)
    found = cut_at_gaps([whole], [without(2000, 3500)], Conditions())
    assert found.recordings == [whole]
    assert len(found.heldout) == 2


def test_short_gaps_are_left() -> None:
    recording = without(2000, 2030)
    found = cut_at_gaps([recording], [], AT_REST)
    assert found.recordings[0] is recording
    assert found.conditions is AT_REST
    assert found.lines == []


def test_readings_that_do_not_count_are_no_gap() -> None:
    """Of a dead sensor the voltage is known."""
    whole = without(0, 0)
    read = np.ones(COUNT, bool)
    read[2000:3500] = False
    recording = Recording("run", PERIOD, whole.voltage, whole.displacement, read=read)
    assert cut_at_gaps([recording], [], AT_REST).recordings[0] is recording


def test_pieces_that_are_too_short_are_left_out() -> None:
    found = cut_at_gaps([without(100, 1600)], [], AT_REST)
    (after,) = found.recordings
    assert after.name == "run.csv from 1.6 s"
