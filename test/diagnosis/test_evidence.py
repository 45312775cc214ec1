"""Of long recordings little is compared, and no effect is cut short."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import STRETCH, Evidence
from microgripper_control.diagnosis.data.residuals import residuals_of
from microgripper_control.diagnosis.fits.trial import Trial, moved, unfitted
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD = 1e-3


def recording(name: str, samples: int, initial: Initial) -> Recording:
    voltage = 75.0 - 70.0 * np.cos(2.0 * np.pi * 0.9 * PERIOD * np.arange(samples))
    answer = simulate(nominal_model(), voltage, PERIOD, initial=initial)
    return Recording(name, PERIOD, voltage, answer)


def gathered(separate: bool, initial: Initial = Initial.FIRST_SAMPLE) -> Evidence:
    runs = [recording("long", 90_000, initial), recording("short", 30_000, initial)]
    others = [recording("held out", 60_000, initial)] if separate else []
    return Evidence.gather(runs, others, Conditions(initial=initial), nominal_model())


@pytest.mark.parametrize("separate", [True, False])
def test_few_samples_all_over_whole_recordings_are_compared(separate: bool) -> None:
    whole = gathered(separate)
    lean = whole.lean(20_000)
    cycle = round(1.0 / (0.9 * PERIOD))
    assert (lean.fitted, lean.judged) == (whole.fitted, whole.judged)
    counted = [np.flatnonzero(mask) for mask in lean.used]
    assert sum(map(len, counted)) == pytest.approx(20_000, rel=0.15)
    for mask, before, found in zip(lean.used, whole.used, counted, strict=True):
        assert not np.any(mask & ~before)
        assert np.ptp(np.histogram(found % cycle, 5)[0]) < 0.4 * len(found)
        assert found[0] < STRETCH < 0.8 * len(mask) < found[-1]
    for less, more in zip(lean.errors(whole.nominal), whole.errors(whole.nominal), strict=True):
        assert 0 < len(less) < 0.5 * len(more)
        assert np.all(np.isin(less, more))


def test_of_joined_recordings_no_sample_is_both_fitted_and_judged() -> None:
    whole = gathered(True)
    joined = whole.joined()
    assert whole.apart
    assert not joined.apart
    assert joined.fitted == (*whole.fitted, *whole.judged)
    assert joined.used[:2] == whole.used
    fitted, judging = joined.used[2], joined.predictions(whole.nominal)[0].counted
    assert not np.any(fitted & judging)
    assert np.count_nonzero(fitted) > 0.4 * len(fitted)
    assert np.count_nonzero(judging) > 0.4 * len(fitted)


def test_of_joined_blocks_half_of_what_judged_judges_on() -> None:
    """No sample is both fitted and judged, none near what judges is fitted, and ends are fitted."""
    whole = gathered(False)
    joined = whole.joined()
    assert joined.fitted == joined.judged == whole.fitted
    before, after = (evidence.predictions(whole.nominal) for evidence in (whole, joined))
    for fitted, one, other in zip(joined.used, before, after, strict=True):
        length, judged, judging = len(fitted), one.counted, other.counted
        assert not np.any(judging & ~judged)
        assert np.count_nonzero(judging) == pytest.approx(0.25 * length, abs=10)
        assert np.count_nonzero(fitted) > 0.55 * length
        near = np.convolve(judging, np.ones(length // 110), mode="same") > 0.5
        assert not np.any(fitted & near)
        assert fitted[-1]


def test_joined_recordings_keep_the_ages_of_their_readings() -> None:
    model = nominal_model().with_link("sensor_lag", clock=1.7e-3)
    whole = Evidence.gather(
        [recording("fitted", 3000, Initial.REST)],
        [recording("held out", 3000, Initial.REST)],
        Conditions(initial=Initial.REST),
        model,
    )
    ages = [one.reading_age for one in whole.joined().fitted]
    assert ages == [whole.fitted[0].reading_age, whole.judged[0].reading_age]
    assert all(age > 0.0 for age in ages)


def test_a_recording_whose_blocks_judge_is_looked_at_once() -> None:
    whole = gathered(False)
    left = residuals_of(whole, whole.nominal)
    assert len(left.fitted) == len(left.judging) == len(left.each_once) == 2
    for one, fitted, judging in zip(left.each_once, left.fitted, left.judging, strict=True):
        assert one.recording is fitted.recording
        np.testing.assert_array_equal(one.counted, fitted.counted | judging.counted)
    apart = gathered(True)
    assert len(residuals_of(apart, apart.nominal).each_once) == 3


def test_what_is_short_enough_stays_as_it_is() -> None:
    whole = gathered(True)
    assert whole.lean() is whole
    assert whole.pieces(200_000) is whole


def test_what_is_short_enough_stays_as_it_is_beside_a_clock_of_the_sensor() -> None:
    clocked = gathered(False).clocked(1e-3, [0.0, 0.0])
    assert clocked.pieces(200_000) is clocked


def test_pieces_are_recordings_of_their_own() -> None:
    pieces = gathered(True).pieces(40_000)
    assert sum(map(len, pieces.fitted)) == pytest.approx(40_000, rel=0.1)
    assert all(len(mask) == len(run) for mask, run in zip(pieces.used, pieces.fitted, strict=True))
    assert all(len(m) == len(run) for m, run in zip(pieces.compared, pieces.judged, strict=True))
    assert {run.name for run in pieces.fitted} == {"long", "short"}


@pytest.mark.parametrize("initial", [Initial.REST, Initial.PERIODIC])
@pytest.mark.parametrize("separate", [True, False])
def test_pieces_begin_as_the_rig_happened_to_be(separate: bool, initial: Initial) -> None:
    """From rest, the right model would be off by the hysteresis of the way that was cut off."""
    whole = gathered(separate, initial)
    pieces = whole.pieces(40_000)
    trial = unfitted(pieces, moved(pieces, Trial(pieces.nominal, (), (), np.inf)))
    assert trial.fitted_rmse < 1e-9
    as_begun = replace(pieces, conditions=whole.conditions)
    assert unfitted(as_begun, moved(as_begun, trial)).fitted_rmse > 2e-8


@pytest.mark.parametrize("separate", [True, False])
def test_a_piece_of_which_no_sample_counts_is_none(separate: bool) -> None:
    """The samples that are fitted may all be ones which answer to what was before the piece."""
    whole = gathered(separate)
    few = np.arange(len(whole.used[0])) < 10
    pieces = replace(whole, used=(whole.used[0] & few, whole.used[1])).pieces(40_000)
    assert {run.name for run in pieces.fitted} == {"short"}
    for mask, run in zip(pieces.used, pieces.fitted, strict=True):
        assert np.any(mask & pieces.conditions.answered(run))
    none = replace(whole, used=tuple(mask & few[: len(mask)] for mask in whole.used))
    assert none.pieces(40_000) is none
