"""The running gap on rigs that differ from the model by nothing, or by what was planted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.running_gap import Reading, RunningGap, Watch
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3
NOISE = 15e-9
RATIO, LEAST = 3.0, 1e-9
TIME = PERIOD * np.arange(14000)
WAVE = 80.0 - 70.0 * np.cos(2.0 * np.pi * TIME)
STEPS = np.repeat(np.random.default_rng(9).uniform(10.0, 150.0, 140), 100)
SMALL = 14.0 - 4.0 * np.cos(2.0 * np.pi * TIME)  # forgets the hysteresis before it slowly
VOLTAGES = {
    "wave": WAVE,
    "slow": 80.0 - 70.0 * np.cos(0.6 * np.pi * TIME),
    "small after large": np.where(TIME < 2.0, WAVE, SMALL),
    "rest, then wave": np.where((TIME > 2.5) & (TIME < 7.5), 150.0, WAVE),
}
JOINED = 2300  # the sample that the comparison begins with: what was before is not known to it


@pytest.fixture
def paper() -> Model:
    return nominal_model()


def measured(rig: Model, voltage: Array, noise: float = NOISE) -> Array:
    clean = simulate(rig, voltage, PERIOD, random=True)
    return clean + np.random.default_rng(1).normal(0.0, noise, len(voltage))


def compare(
    gap: RunningGap, voltage: Array, displacement: Array, first: int = JOINED
) -> tuple[list[Reading], Watch]:
    """All readings, ten a second, and the watch that has seen them."""
    readings, watch = [], Watch()
    for k in range(first, len(voltage)):
        gap.sample(k, voltage[k], displacement[k])
        if k % 100 == 0 and (reading := gap.reading()) is not None:
            readings.append(reading)
            watch.judge(reading, RATIO, LEAST)
            if not watch.holds:
                break
    return readings, watch


@pytest.mark.parametrize("voltage", VOLTAGES.values(), ids=VOLTAGES)
@pytest.mark.parametrize("noise", [NOISE, 1e-9])
def test_a_model_that_is_right_holds_whatever_was_before(
    paper: Model, voltage: Array, noise: float
) -> None:
    rig = paper.with_link("sensor_zero", offset=3e-6)
    displacement = measured(rig, voltage, noise)
    readings, watch = compare(RunningGap(paper, PERIOD, 5.0), voltage, displacement)
    assert watch.holds
    if voltage is WAVE:
        assert watch.judged is readings[-1]
        assert readings[-1].gap == pytest.approx(noise, rel=0.05)
        assert readings[-1].ratio == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("frequency", [0.2, 1.0])
@pytest.mark.parametrize(("noise", "zero"), [(5e-9, 0.0), (5e-9, 0.5e-6), (100e-9, 0.5e-6)])
@pytest.mark.parametrize(("gain", "holds"), [(1.0, True), (1.4, False)])
def test_a_coarse_sensor_is_no_gap_and_hides_none(
    paper: Model, frequency: float, noise: float, zero: float, gain: float, holds: bool
) -> None:
    """The sensor's noise is there before it rounds; its steps are 1 um."""
    voltage = 80.0 - 70.0 * np.cos(2.0 * np.pi * frequency * TIME)
    rig = paper.with_values({("bouc_wen", "d"): gain * paper.value("bouc_wen", "d")})
    shown = 1e-6 * np.rint((measured(rig, voltage, noise) + zero) / 1e-6)
    model = paper.with_link("sensor_quantization", resolution=1e-6)
    _, watch = compare(RunningGap(model, PERIOD, 5.0), voltage, shown)
    assert watch.judged is not None
    assert watch.holds == holds


@pytest.mark.parametrize(("clock", "frequency"), [(0.667e-3, 5.0), (2.5e-3, 1.0), (5e-3, 1.0)])
@pytest.mark.parametrize(("gain", "holds"), [(1.0, True), (1.4, False)])
def test_when_a_sensor_converts_is_no_gap(
    paper: Model, clock: float, frequency: float, gain: float, holds: bool
) -> None:
    """The model's clock begins with the watch, the rig's at some other time."""
    model = paper.with_link("sensor_lag", averaging=0.0, time_constant=0.0, clock=clock)
    voltage = 80.0 - 70.0 * np.cos(2.0 * np.pi * frequency * TIME)
    rig = model.with_values({("bouc_wen", "d"): gain * model.value("bouc_wen", "d")})
    clean = simulate(rig, voltage, PERIOD, reading_age=0.4 * clock)
    shown = clean + np.random.default_rng(1).normal(0.0, 5e-9, len(voltage))
    _, watch = compare(RunningGap(model, PERIOD, 5.0), voltage, shown)
    assert watch.judged is not None
    assert watch.holds == holds


def test_what_the_hysteresis_brought_along_is_mostly_taken_away(paper: Model) -> None:
    voltage = VOLTAGES["small after large"]
    readings, _ = compare(RunningGap(paper, PERIOD, 5.0), voltage, measured(paper, voltage, 1e-9))
    assert readings[0].gap < 120e-9  # of 220 nm
    assert readings[-1].gap < 30e-9  # of 50 nm


def test_without_noise_and_from_rest_nothing_is_left(paper: Model) -> None:
    readings, _ = compare(RunningGap(paper, PERIOD, 5.0), WAVE, measured(paper, WAVE, 0.0), 0)
    assert readings[-1].gap < 1e-13


@pytest.mark.parametrize(
    ("link", "values", "voltage"),
    [
        ("backlash", {"play": 3e-7}, WAVE),
        ("transport_delay", {"delay": 2e-3}, WAVE),
        ("transport_delay", {"delay": 2e-3}, STEPS),
        ("sensor_lag", {}, STEPS),
        ("creep", {}, WAVE),
        ("bouc_wen", {"alpha": 0.09}, WAVE),
    ],
)
def test_a_model_that_lacks_something_does_not_hold(
    paper: Model, link: str, values: dict[str, float], voltage: Array
) -> None:
    known = paper.values(link) if link in paper.settings else {}
    rig = paper.with_link(link, **{**known, **values})
    displacement = measured(rig, voltage)
    readings, watch = compare(RunningGap(paper, PERIOD, 5.0), voltage, displacement)
    assert not watch.holds
    assert 0.9 * NOISE < readings[-1].noise_floor < 4.0 * NOISE
    readings, watch = compare(RunningGap(rig, PERIOD, 5.0), voltage, displacement)
    assert watch.holds


def test_a_hum_of_any_phase_is_no_gap_to_a_model_that_hums(paper: Model) -> None:
    rig = paper.with_link("mains_hum", amplitude=2e-7, phase=1.0)
    displacement = measured(rig, WAVE)
    readings, _ = compare(RunningGap(paper, PERIOD, 5.0), WAVE, displacement)
    assert readings[-1].ratio > 3.0
    readings, _ = compare(RunningGap(rig, PERIOD, 5.0), WAVE, displacement)
    assert readings[-1].gap == pytest.approx(NOISE, rel=0.05)


def test_a_zero_that_the_model_fixes_is_one(paper: Model) -> None:
    displacement = measured(paper, WAVE)
    fixed = paper.with_link("sensor_zero", offset=0.0)
    for off, ratio in ((0.0, 1.0), (1e-6, 60.0)):
        readings, _ = compare(RunningGap(fixed, PERIOD, 5.0), WAVE, displacement + off)
        assert readings[-1].gap > 0.9 * ratio * NOISE
        readings, _ = compare(RunningGap(paper, PERIOD, 5.0), WAVE, displacement + off)
        assert readings[-1].gap == pytest.approx(NOISE, rel=0.05)


def test_through_missing_samples_the_voltage_is_held(paper: Model) -> None:
    rng = np.random.default_rng(5)
    there = np.cumsum(rng.choice([1, 1, 1, 1, 2, 9], size=4000))
    there = there[there < len(TIME)]
    voltage = WAVE[there[np.searchsorted(there, np.arange(len(TIME)), side="right") - 1]]
    displacement = measured(paper, voltage)
    gap, reading = RunningGap(paper, PERIOD, 1.0), None
    for k in there:
        gap.sample(int(k), voltage[k], displacement[k])
        gap.sample(int(k), 0.0, 1.0)  # one that repeats is ignored
    reading = gap.reading()
    assert reading is not None
    assert reading.gap == pytest.approx(NOISE, rel=0.1)
    gap.restart()
    assert gap.reading() is None


def test_a_model_that_grows_without_bound_is_begun_again(paper: Model) -> None:
    ratchet = paper.with_values({("bouc_wen", "beta"): -0.5})
    readings, _ = compare(RunningGap(ratchet, PERIOD, 0.5), WAVE, measured(paper, WAVE))
    assert np.all(np.isfinite([reading.gap for reading in readings]))


def test_a_verdict_does_not_waver() -> None:
    watch = Watch()
    floor = 1e-8
    verdicts = []
    for ratio in (1.0, 2.9, 3.1, 2.9, 2.5, 3.1, 2.3, 2.9, 3.1):
        watch.judge(Reading(ratio * floor, floor, 0.0, True), RATIO, LEAST)
        verdicts.append(watch.holds)
    assert verdicts == [True, True, False, False, False, False, True, True, False]


@pytest.mark.parametrize("changes", [{"moving": False}, {"doubt": 2e-8}])
def test_a_window_that_cannot_tell_changes_no_verdict(changes: dict[str, float]) -> None:
    watch = Watch()
    bad = Reading(1e-7, 1e-8, 0.0, True)
    watch.judge(replace(bad, **changes), RATIO, LEAST)  # type: ignore[arg-type]
    assert watch.holds
    assert watch.judged is None
    watch.judge(bad, RATIO, LEAST)
    watch.judge(replace(bad, gap=1e-8, **changes), RATIO, LEAST)  # type: ignore[arg-type]
    assert not watch.holds
    assert watch.judged is bad


def test_a_gap_that_is_small_enough_is_none() -> None:
    watch = Watch()
    watch.judge(Reading(9e-10, 1e-12, 0.0, True), RATIO, LEAST)
    assert watch.holds
