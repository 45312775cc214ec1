from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.nodes.kept_samples import KeptSamples
from microgripper_control.nodes.new_time import AGREE

PERIOD = 1_000_000  # ns
START = 1_700_000_000 * 10**9


def add(kept: KeptSamples, ticks: range | list[int], start: int = START) -> list[bool]:
    return [kept.add(start + tick * PERIOD, float(tick), 1e-9 * tick) for tick in ticks]


def test_the_last_seconds_are_kept() -> None:
    kept = KeptSamples(1000.0, 2.0)
    assert kept.duration == 0.0
    assert not any(add(kept, range(5000)))
    assert kept.duration == pytest.approx(2.0)
    recording = kept.recording()
    assert recording.sample_period == 1e-3
    assert recording.start == 0.0
    np.testing.assert_array_equal(recording.voltage, np.arange(2999.0, 5000.0))
    np.testing.assert_array_equal(recording.measured, 1e-9 * np.arange(2999, 5000))
    assert (kept.count, kept.missing, kept.restarts, kept.tick) == (5000, 0, 0, 4999)


def test_missing_samples_are_counted_and_known_in_the_recording() -> None:
    kept = KeptSamples(1000.0, 10.0)
    ticks = [tick for tick in range(1000) if tick not in (100, 101, 500)]
    assert not any(add(kept, ticks))
    assert kept.missing == 3
    assert kept.tick == 999
    recording = kept.recording()
    assert len(recording) == 1000
    np.testing.assert_array_equal(np.flatnonzero(~recording.present), [100, 101, 500])


@pytest.mark.parametrize("start", [START - PERIOD, 0, START + 3000 * PERIOD])
def test_time_that_jumps_is_a_new_beginning(start: int) -> None:
    kept = KeptSamples(1000.0, 10.0)
    add(kept, range(100))
    doubted = AGREE - 1
    assert add(kept, range(50), start) == [*doubted * [False], True, *(49 - doubted) * [False]]
    assert kept.restarts == 1
    assert (kept.missing, kept.disbelieved) == (0, doubted)
    assert kept.tick == 49 - doubted
    assert len(kept.recording()) == 50 - doubted


@pytest.mark.parametrize("wild", [-3_600_000, -2, 3_600_000])
def test_one_stamp_from_another_time_forgets_nothing(wild: int) -> None:
    kept = KeptSamples(1000.0, 10.0)
    ticks = [*range(100), 99 + wild, *range(100, 200)]
    assert not any(add(kept, ticks))
    assert (kept.count, kept.missing, kept.restarts, kept.disbelieved) == (200, 0, 0, 1)
    np.testing.assert_array_equal(kept.recording().voltage, np.arange(200.0))


@pytest.mark.parametrize("every", [2, 5])
def test_another_rate_is_seen_and_does_no_harm(every: int) -> None:
    kept = KeptSamples(1000.0, 2.0)
    add(kept, range(0, 6000, every))
    assert kept.interval == pytest.approx(every * 1e-3)
    assert kept.recording().sample_period == every * 1e-3
    assert kept.duration == pytest.approx(2.0, abs=1e-2)


def test_too_few_samples_are_an_error() -> None:
    kept = KeptSamples(1000.0, 2.0)
    add(kept, range(5))
    with pytest.raises(MicrogripperError, match="joint_states: 5 samples; at least 10"):
        kept.recording()
