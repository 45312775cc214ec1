"""Where the gap lies: planted places are found, and nothing is where there is nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from planted_residuals import (
    GAIN,
    NOISE,
    PERIOD,
    loops,
    motion,
    multisine,
    planted,
    staircase,
)
from scipy.signal import butter, lfilter

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.answers.places import place
from microgripper_control.diagnosis.data.residuals import Residual
from microgripper_control.diagnosis.findings import Range
from microgripper_control.diagnosis.signs.freeform import explainable
from microgripper_control.diagnosis.signs.holds import growth_in_holds
from microgripper_control.diagnosis.signs.signatures import signatures
from microgripper_control.diagnosis.signs.where import locate, recent_rate


def time_of(voltage: Array) -> Array:
    return PERIOD * np.arange(len(voltage))


def on(axis: str, found: list[Range]) -> Range:
    """The one range of an axis."""
    ranges = [one for one in found if one.axis == axis]
    assert len(ranges) == 1, found
    return ranges[0]


@pytest.mark.parametrize("seed", range(20))
def test_white_noise_is_nowhere(seed: int) -> None:
    drives = (loops(), staircase(seed=seed), multisine(seed=seed))
    assert locate([planted(drives[seed % 3], 0.0, seed)], NOISE) == []


def test_a_gap_that_is_everywhere_alike_is_nowhere() -> None:
    voltage = multisine()
    rough = lfilter([1.0], [1.0, -0.5], np.random.default_rng(1).standard_normal(len(voltage)))
    assert locate([planted(voltage, 40e-9 * rough)], NOISE) == []


@pytest.mark.parametrize("mains", [49.97, 60.02])
@pytest.mark.parametrize("size", [12e-9, 100e-9])
def test_hum_is_a_line(mains: float, size: float) -> None:
    voltage = loops()
    hum = size * np.sin(2.0 * np.pi * mains * time_of(voltage) + 0.3)
    first = locate([planted(voltage, hum)], NOISE)[0]
    assert first.axis == "frequency_Hz"
    assert first.low == pytest.approx(mains - 0.5, abs=0.1)
    assert first.high == pytest.approx(mains + 0.5, abs=0.1)
    assert first.share_of_gap > 0.5


def test_a_resonance_is_a_band_around_it() -> None:
    voltage = staircase()
    decay, omega = np.exp(-0.04 * 2.0 * np.pi * 180.0 * PERIOD), 2.0 * np.pi * 180.0 * PERIOD
    poles = [1.0, -2.0 * decay * np.cos(omega), decay**2]
    ringing = lfilter([1.0, -1.0], poles, motion(voltage)) * 0.1
    found = on("frequency_Hz", locate([planted(voltage, ringing)], NOISE))
    assert found.low < 180.0 < found.high
    assert found.high - found.low < 40.0


def test_drift_is_slow() -> None:
    voltage = loops(30000)
    drift = 4e-7 * (1.0 - np.exp(-time_of(voltage) / 20.0))
    found = on("frequency_Hz", locate([planted(voltage, drift)], NOISE))
    assert (found.low, found.high) == (0.0, 0.2)
    assert found.share_of_gap > 0.8


@pytest.mark.parametrize("voltage", [loops(), multisine()], ids=["loops", "multisine"])
def test_contact_begins_at_its_position_even_behind_a_refit(voltage: Array) -> None:
    x = motion(voltage)
    pressed = -0.05 * np.maximum(x - 11e-6, 0.0)
    # As a refit would: gain and zero are taken away.
    columns = np.stack([x, np.ones(len(x))], axis=1)
    left = pressed - columns @ np.linalg.lstsq(columns, pressed, rcond=None)[0]
    found = on("displacement_m", locate([planted(voltage, left)], NOISE))
    assert found.low == pytest.approx(11e-6, abs=0.6e-6)
    assert found.high == pytest.approx(x.max(), rel=0.02)


def test_a_smooth_curve_is_no_contact() -> None:
    voltage = loops()
    x = (motion(voltage) / GAIN - 75.0) / 75.0
    found = locate([planted(voltage, 200e-9 * (x**3 - 0.6 * x))], NOISE)
    assert not [one for one in found if one.axis == "displacement_m" and one.low > -1.0]


def test_saturation_begins_at_its_level() -> None:
    voltage = loops()
    missing = -GAIN * 0.1 * np.maximum(voltage - 120.0, 0.0)
    found = on("voltage_V", locate([planted(voltage, missing)], NOISE))
    assert found.low == pytest.approx(120.0, abs=5.0)
    assert found.high == pytest.approx(voltage.max())


def test_a_slip_lasts_from_its_instant_to_the_end() -> None:
    voltage = loops(30000)
    slip = np.where(time_of(voltage) > 18.3, 2e-7, 0.0)
    found = on("time_s", locate([planted(voltage, slip)], NOISE))
    assert found.low == pytest.approx(18.3, abs=0.2)
    assert found.high == pytest.approx(30.0, abs=0.1)


def crept(voltage: Array, per_decade: float) -> Array:
    """Logarithmic growth after each step, m."""
    x, time = GAIN * voltage, time_of(voltage)
    grown = np.zeros(len(x))
    for k in np.flatnonzero(np.diff(x)) + 1:
        grown[k:] += per_decade * (x[k] - x[k - 1]) * np.log10(1.0 + (time[k:] - time[k]) / 0.05)
    return grown


def test_creep_goes_on_through_the_holds() -> None:
    voltage = staircase()
    found = on("hold_time_s", locate([planted(voltage, crept(voltage, 0.01))], NOISE))
    assert found.low == pytest.approx(0.1)
    assert found.high == pytest.approx(1.5, abs=0.05)


def test_the_growth_of_creep_per_decade_is_read_off_the_holds() -> None:
    voltage = staircase(60000)
    growth = growth_in_holds([planted(voltage, crept(voltage, 0.01))], 0.1)
    assert growth is not None
    assert growth.per_decade == pytest.approx(0.01, rel=0.3)
    assert growth.certainty > 4.0


def test_error_after_fast_changes_alone() -> None:
    steps = np.repeat(staircase(300000)[::1500], 150)
    voltage = loops(30000) / 3.0 + np.where(np.arange(30000) // 3000 % 4 < 2, steps[:30000], 0.0)
    late = np.where(recent_rate(planted(voltage, 0.0).recording) > 5e3, 3e-7, 0.0)
    found = on("rate_V_per_s", locate([planted(voltage, late, odd=True)], NOISE))
    assert found.low > 300.0
    assert found.share_of_gap > 0.9


def test_the_fastest_of_a_few_rates_is_told_from_the_others() -> None:
    """The rate of a triangle is one value but for rounding errors, and many samples share it."""
    rates = np.repeat([100.0, 200.0, 465.0], [16000, 16000, 8000])  # V/s
    travel = PERIOD * np.cumsum(rates)
    voltage = 50.0 + 2.0 * np.abs((travel + 25.0) % 100.0 - 50.0) - 50.0
    late = np.where(rates > 300.0, 2e-7 * np.sin(2.0 * np.pi * 3.1 * time_of(voltage)), 0.0)
    found = on("rate_V_per_s", locate([planted(voltage, late)], NOISE))
    assert found.low == pytest.approx(930.0)
    assert found.high == pytest.approx(930.0)
    assert "about 930 V/s" in place(found)


def test_one_direction_alone() -> None:
    voltage = loops()
    rising = np.gradient(voltage) > 0.0
    shape = np.sin(2.0 * np.pi * 3.1 * time_of(voltage))
    found = on("direction", locate([planted(voltage, np.where(rising, 1e-7 * shape, 0.0))], NOISE))
    assert (found.low, found.high) == (1.0, 1.0)


def test_runs_and_holds_of_a_residual() -> None:
    residual = planted(staircase(), 0.0)
    assert [run.stop - run.start for run in residual.runs(100)] == [3000] * 5
    holds = residual.holds(1.0)
    assert all(hold.stop - hold.start == 1499 for hold in holds)
    assert float(np.nanmax(residual.hold_time)) == pytest.approx(1.499)
    assert isinstance(residual, Residual)


def cut(residual: Residual, count: int) -> Residual:
    """Its first samples."""
    recording = residual.recording
    short = Recording("short", PERIOD, recording.voltage[:count], recording.measured[:count])
    return Residual(short, residual.error[:count], np.arange(count) % 10 > 4)


@pytest.mark.parametrize("noise", [0.0, NOISE])
@pytest.mark.parametrize("count", [12, 150, 2000])
def test_little_or_perfect_data_are_no_failure(count: int, noise: float) -> None:
    residual = cut(planted(loops(), 0.0), count)
    perfect = replace(residual, error=np.zeros(count))
    assert locate([perfect], noise) == []
    assert {one.agrees for one in signatures([perfect], noise)} <= {None, False}
    assert explainable([perfect], [perfect], noise) == 0.0
    locate([residual], noise)
    signatures([residual], noise)
    explainable([residual], [residual], noise)


def test_recordings_of_two_clocks_go_together() -> None:
    voltage = loops()
    hum = 100e-9 * np.sin(2.0 * np.pi * 50.0 * time_of(voltage))
    one = planted(voltage, hum)
    half = Recording("half", 2.0 * PERIOD, voltage[::2].copy(), one.recording.measured[::2].copy())
    other = Residual(half, one.error[::2], one.counted[::2])
    found = [place for place in locate([one, other], NOISE) if place.axis == "frequency_Hz"]
    assert found
    assert all(place.low < 50.0 < place.high for place in found)


def test_a_contact_lies_at_one_place_whatever_the_zeros_of_the_recordings() -> None:
    voltage = loops()
    x = motion(voltage)
    pressed = -0.1 * np.maximum(x - 12e-6, 0.0)
    found = []
    for zeros in ((0.0, 0.0), (-3e-6, 3e-6), (-50e-6, 50e-6)):
        residuals = [
            replace(planted(voltage, pressed, seed, predicted=x + zero), zero=zero)
            for seed, zero in enumerate(zeros)
        ]
        found.append(on("displacement_m", locate(residuals, NOISE)).low)
    assert found[0] == pytest.approx(12e-6, abs=0.6e-6)
    assert found[1:] == pytest.approx([found[0]] * 2, abs=1e-8)


def test_a_line_is_placed_as_closely_as_its_spectrum_shows() -> None:
    """No frequency is negative, however slow the line, and a short recording shows a wide one."""
    for period, frequency in ((0.05, 0.31), (5e-6, 23_000.0)):
        voltage = loops(30000)
        time = period * np.arange(len(voltage))
        planned = planted(voltage, 60e-9 * np.sin(2.0 * np.pi * frequency * time))
        recording = replace(planned.recording, sample_period=period)
        line = on("frequency_Hz", locate([replace(planned, recording=recording)], NOISE))
        assert 0.0 <= line.low < frequency < line.high
        assert line.high - line.low >= 1.0 / time[-1]


def ramps_with_rests() -> tuple[Array, Array]:
    """Up, rest, down, rest, half a second each: the voltage, and the time since it last moved."""
    up, rest = np.linspace(0.0, 150.0, 500, endpoint=False), np.full(500, 150.0)
    voltage = np.tile(np.concatenate([up, rest, 150.0 - up, 0.0 * rest]), 27)
    index = np.arange(len(voltage))
    moved = np.diff(voltage, prepend=voltage[0]) != 0.0
    return voltage, PERIOD * (index - np.maximum.accumulate(np.where(moved, index, 0)))


def test_a_share_is_one_of_the_whole_gap() -> None:
    """Most of it lies elsewhere than where the axis has a value."""
    voltage, since = ramps_with_rests()
    rises = np.diff(voltage, prepend=voltage[0]) > 0.0
    white = np.random.default_rng(1).standard_normal(len(voltage))
    while_moving = np.where(since == 0.0, 100e-9, np.where(since <= 0.05, 120e-9, 0.0))
    found = locate([planted(voltage, while_moving * white)], NOISE)
    assert not {"hold_time_s"} & {one.axis for one in found}
    at_rest = np.where(rises, 60e-9, np.where(since > 0.0, 150e-9, 0.0))
    found = locate([planted(voltage, at_rest * white)], NOISE)
    assert not {"direction"} & {one.axis for one in found}
    mostly_rising = np.where(rises, 200e-9, np.where(since > 0.0, 60e-9, 0.0))
    residual = planted(voltage, mostly_rising * white)
    power = residual.error**2 - NOISE**2
    share = np.sum(power[rises & residual.counted]) / np.sum(power[residual.counted])
    assert 0.7 < share < 0.9
    assert on("direction", locate([residual], NOISE)).share_of_gap == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("cycles", [18, 20, 40, 60])
def test_a_direction_is_found_whatever_the_number_of_cycles(cycles: int) -> None:
    phase = np.arange(1000 * cycles) % 1000 / 1000.0
    voltage = 300.0 * np.minimum(phase, 1.0 - phase)
    rises = np.diff(voltage, prepend=0.0) > 0.0
    white = np.random.default_rng(1).standard_normal(len(voltage))
    residual = planted(voltage, 150e-9 * rises * white)
    found = locate([replace(residual, counted=np.ones(len(voltage), bool))], NOISE)
    assert on("direction", found).low == 1.0


def test_a_jump_in_a_piece_is_timed_from_the_beginning_of_the_recording() -> None:
    voltage = loops(60_000)
    lost = slice(20_000, 22_000)
    recorded = np.ones(len(voltage), bool)
    recorded[lost] = False
    voltage[lost] = voltage[lost.start]
    slip = np.where(time_of(voltage) >= 45.0, 400e-9, 0.0)
    shown = motion(voltage) + slip + NOISE * np.random.default_rng(0).standard_normal(60_000)
    whole = Recording("run", PERIOD, voltage, shown, start=1.7e9, recorded=recorded)
    pieces = [whole.stretch(slice(0, lost.start)), whole.stretch(slice(lost.stop, None))]
    left = []
    for piece in pieces:
        first = round((piece.start - whole.start) / PERIOD)
        error = piece.measured - motion(voltage)[first : first + len(piece)]
        left.append(Residual(piece, error - error.mean(), np.ones(len(piece), bool)))
    found = on("time_s", locate(left, NOISE))
    assert (found.low, found.high) == pytest.approx((45.0, 60.0), abs=0.2)


def not_counting(residual: Residual, part: slice, readings: Array) -> Residual:
    """The same with some readings that do not count in the place of others."""
    shown, read = residual.recording.measured.copy(), np.ones(len(residual.error), bool)
    shown[part], read[part] = readings, False
    said = residual.recording.measured - residual.error
    recording = replace(residual.recording, displacement=shown, read=read)
    return Residual(recording, shown - said, residual.counted & read)


@pytest.mark.parametrize(("slow", "drifts"), [(True, True), (False, None)])
def test_readings_that_do_not_count_make_no_drift_and_hide_none(
    slow: bool, drifts: bool | None
) -> None:
    voltage = loops(30_000)
    time = time_of(voltage)
    course = 4e-7 * (1.0 - np.exp(-time / 20.0))
    residual = planted(voltage, course if slow else 60e-9 * np.sin(2.0 * np.pi * 3.0 * time))
    residual = replace(residual, counted=np.ones(len(voltage), bool))
    part = slice(700, 6700)
    stale = not_counting(residual, part, np.full(6000, residual.recording.measured[700]))
    for one in (residual, stale):
        signs = {sign.effect: sign.agrees for sign in signatures([one], NOISE)}
        assert signs.get("thermal_drift") == drifts
        slowest = [p for p in locate([one], NOISE) if p.axis == "frequency_Hz" and p.low == 0.0]
        assert bool(slowest) == slow


def pressed(rate: float) -> Residual:
    """Beyond 12 um something pushes back; what a straight line takes of it is taken off."""
    count = round(20.0 * rate)
    time = np.arange(count) / rate
    voltage = 75.0 * (1.0 - np.linspace(1.0, 0.5, count) * np.cos(2.0 * np.pi * 0.35 * time))
    way = motion(voltage)
    push = -0.1 * np.maximum(way - 12e-6, 0.0)
    line = np.stack([way, np.ones(count)], axis=1)
    push = push - line @ np.linalg.lstsq(line, push, rcond=None)[0]
    error = push + NOISE * np.random.default_rng(0).standard_normal(count)
    return Residual(Recording("r", 1.0 / rate, voltage, way + error), error, np.ones(count, bool))


@pytest.mark.parametrize("rate", [1e3, 5e3, 20e3])
def test_a_bend_is_found_at_any_rate(rate: float) -> None:
    found = on("displacement_m", locate([pressed(rate)], NOISE))
    assert found.low == pytest.approx(12.0e-6, abs=0.1e-6)


def test_a_burst_that_does_not_count_neither_hides_a_bend_nor_ends_its_range() -> None:
    residual = pressed(1e3)
    part = slice(4246, 4326)  # about an upper turn
    burst = 5e-6 * np.random.default_rng(9).standard_normal(80)
    wild = not_counting(residual, part, residual.recording.measured[part] + burst)
    found = on("displacement_m", locate([wild], NOISE))
    assert found.low == pytest.approx(12.0e-6, abs=0.1e-6)
    assert found.high == np.max(wild.position[wild.counted])


def test_no_band_ends_beyond_what_the_sampling_shows() -> None:
    fast = lfilter(
        *butter(2, [0.5, 0.98], "band"), np.random.default_rng(2).standard_normal(20_000)
    )
    found = on("frequency_Hz", locate([planted(loops(), 120e-9 * fast)], NOISE))
    assert 200.0 < found.low < found.high == 500.0
