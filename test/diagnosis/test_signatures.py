"""Fit-free tests: each sees its own effect, and nothing in noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from planted_residuals import GAIN, NOISE, PERIOD, loops, motion, multisine, planted, staircase
from scipy.signal import lfilter

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.residuals import Residual
from microgripper_control.diagnosis.findings import Signature
from microgripper_control.diagnosis.signs.reversals import _slopes_without, widths_by_rate
from microgripper_control.diagnosis.signs.signatures import signatures
from microgripper_control.diagnosis.signs.spectra import same_clock
from microgripper_control.diagnosis.signs.where import locate
from microgripper_control.effects.registry import registry


def said(residual: Residual) -> dict[str, Signature]:
    return {one.effect: one for one in signatures([residual], NOISE)}


def test_each_is_of_an_effect_of_the_library_and_says_something() -> None:
    for effect, signature in said(planted(loops(), 0.0)).items():
        assert effect in registry()
        assert signature.statement.endswith(".")
        assert len(signature.statement) > 20


@pytest.mark.parametrize("seed", range(6))
def test_white_noise_has_no_signature(seed: int) -> None:
    drives = (loops(), staircase(seed=seed), multisine(seed=seed))
    assert not [one for one in said(planted(drives[seed % 3], 0.0, seed)).values() if one.agrees]


def test_hum_is_seen_and_its_absence_too() -> None:
    voltage = loops()
    hum = 40e-9 * np.sin(2.0 * np.pi * 50.0 * PERIOD * np.arange(len(voltage)))
    seen = said(planted(voltage, hum))["mains_hum"]
    assert seen.agrees
    assert "50.0" in seen.statement
    assert said(planted(voltage, 0.0))["mains_hum"].agrees is False


def test_a_lost_sample_hides_no_line() -> None:
    voltage = loops()
    hum = 30e-9 * np.sin(2.0 * np.pi * 50.0 * PERIOD * np.arange(len(voltage)))
    counted = np.ones(len(voltage), bool)
    counted[70] = False
    residual = replace(planted(voltage, hum), counted=counted)
    assert said(residual)["mains_hum"].agrees
    place = locate([residual], NOISE)[0]
    assert place.high - place.low < 2.0


def test_recordings_of_one_clock_have_one_spectrum() -> None:
    """Stamps that jitter give each of them a period of its own."""
    hum = 100e-9 * np.sin(2.0 * np.pi * 50.0 * PERIOD * np.arange(20000))
    one = planted(loops(), hum)
    other = replace(one, recording=replace(one.recording, sample_period=PERIOD * (1.0 + 1e-9)))
    assert [len(group) for group in same_clock([one, other])] == [2]
    slower = replace(one, recording=replace(one.recording, sample_period=2.0 * PERIOD))
    assert [len(group) for group in same_clock([slower, other, one])] == [2, 1]


def test_a_band_counts_as_a_share_of_the_gap_of_all_clocks() -> None:
    hum = 30e-9 * np.sin(2.0 * np.pi * 50.0 * PERIOD * np.arange(20000))
    quiet = planted(loops(), hum)
    rough = lfilter([1.0], [1.0, -0.5], np.random.default_rng(1).standard_normal(20000))
    loud = planted(multisine(), 400e-9 * rough)
    loud = replace(loud, recording=replace(loud.recording, sample_period=0.5 * PERIOD))
    shares = [p.share_of_gap for p in locate([quiet, loud], NOISE) if 49.0 < p.low < 51.0]
    assert all(share < 0.05 for share in shares)


def test_what_is_brief_is_not_slow() -> None:
    voltage = loops(1000, 3.0)
    wave = 200e-9 * np.sin(2.0 * np.pi * PERIOD * np.arange(1000))
    assert not said(planted(voltage, wave))["thermal_drift"].agrees
    assert not [place for place in locate([planted(voltage, wave)], NOISE) if place.high == 0.2]


def test_slopes_without_a_piece_are_those_of_the_others() -> None:
    random = np.random.default_rng(2)
    x, y, piece = random.normal(size=300), random.normal(size=300), random.integers(0, 7, 300)
    found = _slopes_without(piece, x, y)
    expected = [np.polyfit(x[piece != out], y[piece != out], 1)[0] for out in range(7)]
    np.testing.assert_allclose(found, expected, rtol=1e-10)
    found = _slopes_without(piece, np.where(piece == 3, 1.7, 0.1), y)
    assert found[3] == 0.0
    assert np.all(found[:3] != 0.0)


def test_readings_on_a_grid() -> None:
    voltage, step = loops(), 1e-7
    residual = planted(voltage, 0.0)
    read = step * np.rint(residual.recording.measured / step)
    error = residual.error + read - residual.recording.measured
    rounded = Residual(Recording("grid", PERIOD, voltage, read), error, residual.counted)
    assert said(rounded)["sensor_quantization"].agrees
    assert said(residual)["sensor_quantization"].agrees is False


@pytest.mark.parametrize(("step", "agrees"), [(5 * NOISE, True), (2 * NOISE, None)])
def test_a_grid_speaks_only_where_it_adds_to_the_noise(step: float, agrees: bool | None) -> None:
    """Readings whose noise is rounded as well: off by 1.8 and by 1.15 times as much."""
    residual = planted(loops(), 0.0)
    read = step * np.rint(residual.recording.measured / step)
    error = residual.error + read - residual.recording.measured
    coarse = Residual(Recording("grid", PERIOD, loops(), read), error, residual.counted)
    assert said(coarse)["sensor_quantization"].agrees is agrees


def test_creep_in_holds_and_its_opposite() -> None:
    voltage = staircase(60000)
    x, time = GAIN * voltage, PERIOD * np.arange(len(voltage))
    grown = np.zeros(len(x))
    for k in np.flatnonzero(np.diff(x)) + 1:
        grown[k:] += 0.01 * (x[k] - x[k - 1]) * np.log10(1.0 + (time[k:] - time[k]) / 0.05)
    assert said(planted(voltage, grown))["creep"].agrees
    assert said(planted(voltage, -grown))["creep"].agrees is False
    assert said(planted(loops(), 1e-7))["creep"].agrees is None


def test_a_delay_keeps_the_amplitude_and_a_lag_loses_it() -> None:
    voltage = multisine()
    x = motion(voltage)
    delayed = np.concatenate([np.full(3, x[0]), x[:-3]])
    late = said(planted(voltage, delayed - x))
    assert late["transport_delay"].agrees
    assert not late["amplifier_lag"].agrees
    decay = float(np.exp(-1.0 / 3.0))
    lagged = lfilter([1.0 - decay], [1.0, -decay], x - x[0]) + x[0]
    lag = said(planted(voltage, lagged - x))
    assert lag["transport_delay"].agrees is False
    assert lag["amplifier_lag"].agrees
    assert lag["sensor_lag"].agrees


def test_the_loss_decides_nothing_where_being_late_explains_little() -> None:
    """A refit that takes part of a delay for hysteresis narrows the fast part of the motion."""
    voltage = multisine()
    x = motion(voltage)
    delayed = np.concatenate([np.full(3, x[0]), x[:-3]])
    slow = lfilter([0.06], [1.0, -0.94], x - x[0]) + x[0]
    found = said(planted(voltage, 0.65 * slow + 0.35 * delayed - x))
    assert "loses 0.6" in found["transport_delay"].statement
    assert found["transport_delay"].agrees
    assert found["sensor_lag"].agrees


def test_broad_motion_without_lateness_contradicts_delay_and_lag() -> None:
    voltage = multisine()
    found = said(planted(voltage, 2e-7 * np.sin(motion(voltage) / 2e-6)))
    assert found["transport_delay"].agrees is False


def test_contact_and_saturation_have_a_threshold() -> None:
    voltage = multisine()
    x = motion(voltage)
    touched = said(planted(voltage, -0.05 * np.maximum(x - 11e-6, 0.0)))["contact"]
    assert touched.agrees
    assert "11" in touched.statement
    clipped = said(planted(voltage, -0.1 * GAIN * np.maximum(voltage - 120.0, 0.0)))["saturation"]
    assert clipped.agrees


def test_where_no_threshold_is_told_the_reason_is() -> None:
    voltage = loops()
    x = (motion(voltage) / GAIN - 75.0) / 75.0
    added = {
        "it may bend, but hardly more sharply than a smooth curve does": np.hypot(x, 0.5),
        "it changes too little to tell": 0.0 * x,
    }
    for reason, residual in added.items():
        one = said(planted(voltage, 200e-9 * residual))["contact"]
        assert one.agrees is None
        assert one.statement.endswith(f"is seen over the displacement: {reason}.")


def test_drift_is_slow_and_not_the_voltages() -> None:
    voltage = loops(30000)
    drift = 3e-7 * (1.0 - np.exp(-PERIOD * np.arange(len(voltage)) / 20.0))
    assert said(planted(voltage, drift))["thermal_drift"].agrees
    assert said(planted(voltage, 1e-9 * voltage))["thermal_drift"].agrees is None


def test_play_stays_behind_after_a_turn() -> None:
    voltage = loops(30000, 1.3)
    x = motion(voltage)
    finger, played = x[0], []
    for position in x.tolist():
        finger = min(max(finger, position - 2e-7), position + 2e-7)
        played.append(finger)
    found = said(planted(voltage, np.array(played) - x))
    assert found["backlash"].agrees
    assert found["friction"].agrees


def test_ringing_after_steps() -> None:
    voltage = staircase()
    decay, turn = np.exp(-0.04 * 2.0 * np.pi * 180.0 * PERIOD), 2.0 * np.pi * 180.0 * PERIOD
    ringing = lfilter([1.0, -1.0], [1.0, -2.0 * decay * np.cos(turn), decay**2], motion(voltage))
    found = said(planted(voltage, 0.1 * ringing))["extra_resonance"]
    assert found.agrees


def test_a_slow_narrow_mode_that_moves_less_than_a_chirp_does() -> None:
    """At 25 Hz it adds 0.4 of the motion, so that only beside its neighbours it stands out."""
    time = PERIOD * np.arange(20000)
    voltage = 75.0 - 70.0 * np.cos(np.pi * 60.0 / time[-1] * time**2)
    x, omega = motion(voltage), 2.0 * np.pi * 25.0
    decay, turn = np.exp(-0.0175 * omega * PERIOD), omega * PERIOD
    poles = [1.0, -2.0 * decay * np.cos(turn), decay**2]
    mode = lfilter([sum(poles)], poles, x - x[0]) + x[0]
    found = said(planted(voltage, 0.015 * (mode - x), odd=True))["extra_resonance"]
    assert found.agrees


def test_a_loop_that_widens_with_the_rate() -> None:
    time = PERIOD * np.arange(40000)
    phase = 2.0 * np.pi * np.cumsum(np.geomspace(0.2, 5.0, len(time))) * PERIOD
    voltage = 75.0 - 70.0 * np.cos(phase)
    pace = np.geomspace(0.2, 5.0, len(time))
    wider = -60e-9 * np.sin(phase) * np.log10(pace / 0.2)
    assert said(planted(voltage, wider))["rate_dependent_hysteresis"].agrees in (True, None)
    assert said(planted(voltage, -wider))["rate_dependent_hysteresis"].agrees is not True


@pytest.mark.parametrize("fastest", [2.0, 10.0, 40.0])
def test_fast_loops_of_a_long_recording_have_their_rate(fastest: float) -> None:
    time = PERIOD * np.arange(60000)
    pace = np.geomspace(0.5, fastest, len(time))
    phase = 2.0 * np.pi * np.cumsum(pace) * PERIOD
    voltage = 75.0 - 70.0 * np.cos(phase)
    wider = -30e-9 * np.sign(np.sin(phase)) * np.log10(pace / 0.5)
    found = widths_by_rate([planted(voltage, wider, predicted=GAIN * voltage)])
    assert found is not None
    assert found.rates[-1] > 0.4 * 70.0 * 2.0 * np.pi * fastest
    assert found.widths[-1] > 30e-9 * np.log10(fastest / 0.5)


@pytest.mark.filterwarnings("error")
def test_triangles_of_two_rates_and_nothing_between() -> None:
    time = PERIOD * np.arange(20000)
    turns = np.concatenate([0.1 * time, 2.0 + time])
    voltage = 75.0 - 70.0 * (1.0 - 4.0 * np.abs((turns % 1.0) - 0.5))
    rising = np.where((turns % 1.0) > 0.5, 1.0, -1.0)
    wider = -30e-9 * rising * (np.arange(len(turns)) >= 20000)
    found = widths_by_rate([planted(voltage, wider)])
    assert found is not None
    assert np.all(np.isfinite(found.rates))
    assert np.all(np.isfinite(found.widths))
    assert 0.5 < found.growth / 60e-9 < 1.1  # a decade apart, less what corners smear


@pytest.mark.parametrize("rate", [0.02, 0.05])
def test_a_loop_is_no_drift_however_slow_the_drive(rate: float) -> None:
    """A play over a slow drive bends slowly as well, but as often as the voltage turns."""
    time = PERIOD * np.arange(200_000)
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * rate * time)
    play = 30e-9 * np.sign(np.sin(2.0 * np.pi * rate * time))
    assert not said(planted(voltage, play))["thermal_drift"].agrees
