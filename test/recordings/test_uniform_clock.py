from __future__ import annotations

import warnings

import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.clock import LARGEST_STEP, on_uniform_clock
from microgripper_control.recordings.samples import Samples

PERIOD = 1e-3
COUNT = 2000
TIME = PERIOD * np.arange(COUNT)


def voltage_at(time: Array) -> Array:
    """A staircase of 10 ms steps."""
    return 10.0 * np.floor(time / 0.01 + 1e-6)


def displacement_at(time: Array) -> Array:
    """10 um at 1 Hz."""
    return 1e-5 * np.sin(2.0 * np.pi * time)


def read(time: Array, *, when: Array | None = None, setpoint: bool = False) -> Recording:
    """What becomes of samples taken at `when` but stamped `time`."""
    when = time if when is None else when
    wanted = 2.0 * displacement_at(when) if setpoint else None
    samples = Samples(time, voltage_at(when), displacement_at(when), wanted, origin=100.0)
    return on_uniform_clock("run", samples)


def test_uniform_samples_stay_as_they_are() -> None:
    recording = read(TIME, setpoint=True)
    assert recording.sample_period == PERIOD
    assert recording.start == 100.0
    assert np.array_equal(recording.voltage, voltage_at(TIME))
    assert np.array_equal(recording.displacement, displacement_at(TIME))
    assert np.array_equal(recording.setpoint, 2.0 * displacement_at(TIME))
    assert recording.warnings == ()


@pytest.mark.parametrize(
    ("rate", "digits"), [(750.0, 9), (750.0, 4), (5000.0, 6), (60.0, 3), (44100.0, 6), (3000.0, 4)]
)
def test_stamps_of_limited_digits_are_uniform(rate: float, digits: int) -> None:
    ticks = np.arange(5000) / rate
    recording = read(np.round(ticks, digits), when=ticks)
    assert recording.warnings == ()
    assert np.array_equal(recording.displacement, displacement_at(ticks))
    assert recording.sample_period == pytest.approx(1.0 / rate, rel=10.0**-digits)


def test_small_jitter_of_the_stamps_is_no_jitter_of_the_samples() -> None:
    jitter = 0.005 * PERIOD * np.random.default_rng(1).standard_normal(COUNT)
    recording = read(TIME + jitter, when=TIME)
    assert recording.warnings == ()
    assert np.array_equal(recording.displacement, displacement_at(TIME))
    assert recording.sample_period == pytest.approx(PERIOD, rel=1e-6)


def test_large_jitter_is_resampled() -> None:
    jitter = 0.2 * PERIOD * np.random.default_rng(1).uniform(-1.0, 1.0, COUNT)
    time = TIME + jitter
    recording = read(time - time[0])
    (warning,) = recording.warnings
    assert "unequally spaced" in warning
    assert "resampled" in warning
    assert len(recording) == pytest.approx(COUNT, abs=2)
    at = recording.time - recording.start
    assert recording.displacement == pytest.approx(displacement_at(at), abs=1e-10)
    # A step is taken over at the nearest instant, half a period away at most.
    assert np.mean(recording.voltage != voltage_at(at)) < 0.06
    assert np.all(np.abs(recording.voltage - voltage_at(at)) <= 10.0)


def read_without(lost: list[int], time: Array) -> Recording:
    """What becomes of ticks that are stamped `time`, of which some are lost: all others stay."""
    present = np.ones(COUNT, bool)
    present[lost] = False
    recording = read(time[present], when=TIME[present])
    assert len(recording) == COUNT
    assert recording.displacement is not None
    assert np.array_equal(recording.displacement[present], displacement_at(TIME[present]))
    assert len(recording.warnings) == 1 + bool(lost)
    return recording


def wandering(jitter: float) -> Array:
    """Stamps of a loop that waits a period after each sample, a little more or less."""
    steps = PERIOD * (1.0 + jitter * np.random.default_rng(5).standard_normal(COUNT - 1))
    return np.append(0.0, np.cumsum(steps))


@pytest.mark.parametrize("jitter", [0.02, 0.05])
@pytest.mark.parametrize("lost", [[], [300, 301, 1700]])
def test_ticks_that_wander_are_taken_one_by_one(jitter: float, lost: list[int]) -> None:
    time = wandering(jitter)
    assert np.ptp(time - TIME) > 0.8 * PERIOD
    recording = read_without(lost, time)
    assert recording.sample_period == pytest.approx(time[-1] / (COUNT - 1), rel=1e-9)
    assert "unequally spaced" in recording.warnings[0]
    assert "taken as ticks of a clock of 0.00100" in recording.warnings[0]


@pytest.mark.parametrize("apart", [1e-7, 0.0])
def test_late_stamps_of_a_wandering_loop_lose_no_sample(apart: float) -> None:
    """Some are late by up to three periods, and those after them are stamped when that is over."""
    rng = np.random.default_rng(6)
    late = np.where(rng.random(COUNT) < 0.02, rng.uniform(0.0, 3.0 * PERIOD, COUNT), 0.0)
    time = np.maximum.accumulate(wandering(0.02) + late) + apart * np.arange(COUNT)
    recording = read(time, when=TIME)
    assert np.array_equal(recording.displacement, displacement_at(TIME))
    assert np.array_equal(recording.voltage, voltage_at(TIME))
    off = np.abs(np.diff(time) / recording.sample_period - 1.0) > LARGEST_STEP
    assert recording.read is not None  # whether a stamp was late or its sample is not to be known
    assert np.array_equal(recording.read, np.append(True, ~off))
    assert f"untimely samples: {np.count_nonzero(off)}" in recording.warnings[1]
    assert len(recording.warnings) == 2


def test_readings_after_a_late_tick_and_while_it_is_caught_up_do_not_count() -> None:
    """The amplifier, short of current, is elsewhere then: marched through the true instants."""
    fine, rng = 1e-5, np.random.default_rng(7)
    steps = np.full(COUNT - 1, 100)
    for at in range(50, COUNT - 10, 200):
        steps[at : at + 4] = (rng.integers(300, 500), 45, 45, 45)
    ticks = np.append(0, np.cumsum(steps))
    voltage = 75.0 + 70.0 * np.sin(2.0 * np.pi * 10.0 * fine * ticks)
    held = voltage[np.searchsorted(ticks, np.arange(ticks[-1] + 1), side="right") - 1]
    rig = nominal_model().with_link("slew_limit", time=1.0 / 2e4)
    measured = simulate(rig, held, fine)[ticks]
    recording = on_uniform_clock("run", Samples(fine * ticks, voltage, measured))
    error = simulate(rig, recording.voltage, recording.sample_period) - recording.displacement
    assert recording.read is not None
    assert np.count_nonzero(recording.read) > 0.95 * COUNT
    assert np.std(error) > 50e-9
    assert np.std(error[recording.read]) < 5e-9


def test_what_a_wandering_loop_records_is_what_the_rig_does() -> None:
    """A rig that is marched through the true instants, held beside one with even ticks."""
    fine = 1e-5
    ticks = np.rint(wandering(0.02) / fine).astype(int)
    voltage = 75.0 + 70.0 * np.sin(2.0 * np.pi * 3.0 * TIME)
    held = voltage[np.searchsorted(ticks, np.arange(ticks[-1] + 1), side="right") - 1]
    measured = simulate(nominal_model(), held, fine)[ticks]
    recording = on_uniform_clock("run", Samples(fine * ticks, voltage, measured))
    error = simulate(nominal_model(), recording.voltage, recording.sample_period) - measured
    assert np.std(error) < 1e-9
    even = np.arange(1990.0)
    resampled = Samples(fine * ticks, voltage, measured).on(fine * ticks / PERIOD, even)
    wrong = simulate(nominal_model(), resampled.voltage, PERIOD) - resampled.displacement
    assert np.std(wrong) > 20e-9


def test_resampling_a_slowly_drifting_clock_meets_the_instants() -> None:
    """Spacing that grows from 1 to 1.5 ms over the run."""
    time = np.cumsum(np.linspace(1e-3, 1.5e-3, COUNT)) - 1e-3
    recording = read(time)
    at = recording.time - recording.start
    assert recording.displacement == pytest.approx(displacement_at(at), abs=2e-10)
    assert at[-1] == pytest.approx(time[-1], abs=1.5e-3)
    assert len(recording.warnings) == 1


def test_missing_samples_are_filled_in_and_the_others_kept() -> None:
    present = np.ones(COUNT, bool)
    present[[7, 500, 501, 502, 1200]] = False
    recording = read(TIME[present], setpoint=True)
    (warning,) = recording.warnings
    assert warning.startswith("missing samples: 5, the longest gap is 0.004 s after sample 498")
    assert len(recording) == COUNT
    assert recording.sample_period == PERIOD
    assert recording.displacement is not None
    assert np.array_equal(recording.displacement[present], displacement_at(TIME[present]))
    assert recording.displacement[501] == pytest.approx(displacement_at(TIME[501]), abs=1e-10)
    assert np.array_equal(recording.voltage[500:503], np.full(3, voltage_at(TIME[499])))
    assert recording.setpoint is not None
    assert recording.setpoint[500] == recording.setpoint[499]


@pytest.mark.parametrize("lost", [1, 20, 1000, 1980, 1998])
def test_one_missing_sample_is_found_wherever_it_is(lost: int) -> None:
    recording = read(np.delete(TIME, lost))
    assert len(recording) == COUNT
    assert recording.displacement == pytest.approx(displacement_at(TIME), abs=1e-10)
    assert recording.warnings[0].startswith("missing samples: 1, the longest gap is 0.002 s")


def test_a_late_stamp_is_no_missing_sample() -> None:
    time = TIME.copy()
    time[1000] += 0.6 * PERIOD
    recording = read(time, when=TIME)
    assert np.array_equal(recording.voltage, voltage_at(TIME))
    assert recording.warnings == ("late stamps: 1, by up to 0.0006 s; taken as on time",)


@pytest.mark.parametrize("lost", [[], [300, 301, 1700]])
def test_a_program_that_stalls_and_catches_up_loses_nothing(lost: list[int]) -> None:
    """Twenty samples are stamped when the stall is over, 0.05 of a period apart."""
    time = TIME.copy()
    time[1000:1020] = TIME[1019] + 0.05 * PERIOD * np.arange(20)
    recording = read_without(lost, time)
    assert recording.warnings[0].startswith("late stamps: 20, by up to 0.019 s")


def test_repeated_stamps_are_dropped() -> None:
    time = np.insert(TIME, [100, 900], TIME[[99, 899]])
    recording = read(time)
    assert recording.warnings == ("repeated samples: 2; they were dropped",)
    assert np.array_equal(recording.displacement, displacement_at(TIME))


def test_stamps_since_1970_keep_their_nanoseconds() -> None:
    samples = Samples(TIME, voltage_at(TIME), origin=1.7e9)
    recording = on_uniform_clock("run", samples, ("cut off",))
    assert recording.sample_period == PERIOD
    assert recording.start == 1.7e9
    assert recording.warnings == ("cut off",)


def test_time_that_runs_backwards_is_an_error() -> None:
    time = TIME.copy()
    time[700:] -= 0.5
    with pytest.raises(MicrogripperError, match=r"run: .* backwards at sample 700, from 0\.699 s"):
        read(time)


@pytest.mark.parametrize("quantity", ["time", "voltage", "displacement"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_an_error(quantity: str, value: float) -> None:
    columns = {"time": TIME, "voltage": voltage_at(TIME), "displacement": displacement_at(TIME)}
    columns[quantity] = columns[quantity].copy()
    columns[quantity][[42, 50]] = value
    with pytest.raises(MicrogripperError, match=rf"run: {quantity} is {value} at sample 42"):
        on_uniform_clock("run", Samples(**columns))


def test_a_time_that_is_no_number_is_told_at_its_own_sample() -> None:
    """Others were overtaken; sorted, it would come last."""
    time = TIME.copy()
    time[[300, 301]] = time[[301, 300]]
    time[42] = np.nan
    with pytest.raises(MicrogripperError, match="time is nan at sample 42; repair it"):
        read(time, when=TIME)


@pytest.mark.parametrize("value", [1e308, -1e308, 1e20])
def test_a_time_that_cannot_be_is_an_error(value: float) -> None:
    time = TIME.copy()
    time[-1] = value
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(MicrogripperError, match=r"time is -?1e\+\d+ at sample 1999; repair"):
            read(time, when=TIME)


def test_too_few_digits_are_an_error() -> None:
    with pytest.raises(MicrogripperError, match="write time with more digits"):
        read(np.floor(TIME * 300.0) / 300.0)


def test_a_recording_that_is_mostly_gaps_is_an_error() -> None:
    time = TIME.copy()
    time[1500:] += 1e7
    with pytest.raises(MicrogripperError, match=r"longest gap is 1e\+07 s after sample 1499; cut"):
        read(time)


@pytest.mark.parametrize("count", [0, 1, 9])
def test_too_few_samples_are_an_error(count: int) -> None:
    with pytest.raises(MicrogripperError, match=f"run: {count} samples; at least 10 are needed"):
        read(TIME[:count])


def test_a_clock_that_stands_still_is_an_error() -> None:
    with pytest.raises(MicrogripperError, match="repeat"):
        read(np.zeros(100))


@pytest.mark.parametrize("count", [2000, 2001])
@pytest.mark.parametrize("burst", [2, 3, 8])
def test_samples_that_are_stamped_in_bursts_are_an_error(burst: int, count: int) -> None:
    k = np.arange(count)
    time = burst * PERIOD * (k // burst) + 1e-6 * (k % burst)
    with pytest.raises(MicrogripperError, match="come in bursts: "):
        read(time, when=PERIOD * k)


def test_a_gap_among_jittering_stamps_does_not_count() -> None:
    jitter = 0.1 * PERIOD * np.random.default_rng(3).standard_normal(COUNT)
    there = np.r_[:700, 1200:COUNT]
    recording = read((TIME + jitter)[there], when=TIME[there])
    assert len(recording) == pytest.approx(COUNT, abs=2)
    assert np.count_nonzero(~recording.present) == pytest.approx(498, abs=3)
    assert not np.any(recording.present[705:1195])
    assert any(line.startswith("missing samples: 500;") for line in recording.warnings)


def test_time_that_often_runs_backwards_is_no_overtaking() -> None:
    """One step in ten goes back, by one sample alone: the stamps are not those of the samples."""
    order = np.arange(COUNT).reshape(-1, 10)
    order[:, [4, 5]] = order[:, [5, 4]]
    with pytest.raises(MicrogripperError, match="time runs backwards at sample 5, "):
        read(TIME[order.ravel()])


def test_a_setpoint_stays_with_its_sample() -> None:
    """Also where samples are put in order, or dropped."""
    order = np.arange(COUNT)
    order[[300, 301]] = order[[301, 300]]
    recording = read(TIME[order], setpoint=True)
    assert np.array_equal(recording.setpoint, 2.0 * displacement_at(TIME))


def test_what_is_held_changes_at_the_instant_that_is_nearer() -> None:
    """A sample 0.3 of a period late is there for most of the way to the next."""
    known = np.array([0.0, 1.3, 2.0, 2.7])
    samples = Samples(PERIOD * known, np.arange(4.0), setpoint=10.0 * np.arange(4.0))
    found = samples.on(known, np.arange(4.0))
    assert found.voltage.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert found.setpoint is not None
    assert found.setpoint.tolist() == [0.0, 10.0, 20.0, 30.0]


def test_samples_that_were_overtaken_are_put_in_order() -> None:
    order = np.arange(COUNT)
    order[[300, 301]] = order[[301, 300]]
    order[[800, 801, 802]] = order[[802, 800, 801]]
    recording = read(TIME[order])
    assert np.array_equal(recording.measured, displacement_at(TIME))
    assert recording.warnings == (
        "overtaken by the next: 2 samples; they were put in the order of stamps",
    )
