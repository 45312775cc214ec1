"""The next experiment tells planted rivals apart, within what the rig has been seen to bear."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.experiments import rehearsal
from microgripper_control.diagnosis.experiments.excitations import Reach, excitations
from microgripper_control.diagnosis.experiments.experiment import next_experiment
from microgripper_control.diagnosis.experiments.rehearsal import BASE, Rehearsal, rivals_of
from microgripper_control.diagnosis.findings import UNKNOWN, Diagnosis, Gap, NextExperiment
from microgripper_control.diagnosis.fits.trial import fitted_keys
from microgripper_control.diagnosis.result_file import NEXT_EXPERIMENT, RESULT, write_result
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording

PERIOD = 1e-3
NOISE = 15e-9
ZERO = Conditions()
PAPER = nominal_model()
AMPLIFIER = PAPER.with_link("amplifier_lag", lag=2e-3, curvature=0.0)
SENSOR = PAPER.with_link("sensor_lag", averaging=0.0, time_constant=2e-3)
LATE = PAPER.with_link("transport_delay", delay=2e-3)
CREEP = PAPER.with_link("creep", strength=0.012)
DRIFT = PAPER.with_link("thermal_drift")
HUM = PAPER.with_link("mains_hum")
FRICTION = PAPER.with_link("friction", coulomb=3.0)
PLAY = PAPER.with_link("backlash", play=1e-7)
MEMORY = PAPER.with_link("restoring_force_hysteresis", alpha=1e6)


def recorded(
    period: float = PERIOD,
    low: float = 0.0,
    high: float = 160.0,
    model: Model = PAPER,
    own: Callable[[Array], Array] = np.zeros_like,
) -> Recording:
    """Slow loops, with what the recording has for itself."""
    t = np.asarray(period * np.arange(20_000), dtype=np.float64)
    voltage = low + (high - low) * (0.5 - 0.5 * np.cos(2.0 * np.pi * 0.25 * t))
    noise = NOISE * np.random.default_rng(1).standard_normal(len(t))
    return Recording("loops", period, voltage, simulate(model, voltage, period) + own(t) + noise)


def proposed(rivals: list[Model], recording: Recording | None = None) -> NextExperiment:
    found = next_experiment(rivals, recording or recorded(), ZERO, NOISE)
    assert found
    return found


def test_it_needs_two_rivals_and_a_voltage_that_all_allow() -> None:
    assert next_experiment([CREEP], recorded(), ZERO, NOISE) is None
    beyond = recorded(low=-100.0, high=-10.0)
    assert next_experiment([CREEP, PAPER], beyond, ZERO, NOISE) is None
    slow = recorded(period=0.5)
    assert next_experiment([CREEP, PAPER], slow, ZERO, NOISE) is None


def test_lags_are_told_apart_by_fast_courses() -> None:
    """Before the hysteresis or behind it: seen only where the voltage is fast and large."""
    found = proposed([AMPLIFIER, SENSOR])
    fastest = np.max(np.abs(np.diff(found.voltage))) / PERIOD
    assert fastest > 100.0 * np.max(np.abs(np.diff(recorded().voltage))) / PERIOD
    assert set(found.separates) == {"amplifier_lag", "sensor_lag"}
    assert "125 Hz" in found.why
    assert "times the noise" in found.why


def test_creep_and_drift_are_told_apart_by_rest_after_repeated_steps() -> None:
    drifting = recorded(own=lambda t: 2e-7 * (1.0 - np.exp(-t / 20.0)))
    found = proposed([CREEP, DRIFT], drifting)
    assert np.count_nonzero(np.diff(found.voltage)) == 10
    assert found.separates == ("creep", "thermal_drift")


def test_a_refit_alone_is_a_rival_too() -> None:
    found = proposed([CREEP, PAPER])
    assert found.separates == ("creep",)
    assert "if it is creep" in found.why
    assert "a mere refit" in found.why


def test_what_the_experiment_promises_is_what_a_refit_leaves() -> None:
    """Against the whole model fitted by brute force in two parameters of the base."""
    found = proposed([CREEP, PAPER])
    truth = simulate(CREEP, found.voltage, PERIOD)[1000:]

    def refitted(alpha: float, gamma: float) -> float:
        changes = {("bouc_wen", "alpha"): alpha, ("bouc_wen", "gamma"): gamma}
        said = simulate(PAPER.with_values(changes), found.voltage, PERIOD)[1000:]
        basis = np.array([said, np.ones_like(said)]).T
        left = truth - basis @ np.linalg.lstsq(basis, truth, rcond=None)[0]
        return float(np.sqrt(np.mean(left**2)))

    best = min(
        refitted(alpha, gamma)
        for alpha in np.linspace(0.06, 0.11, 11)
        for gamma in np.linspace(-0.03, -0.015, 7)
    )
    promised = float(found.why.split(" nm rms")[0].split(" ")[-1]) * 1e-9
    assert 0.5 * best < promised <= 1.01 * best  # beta and the initial h give way as well


def test_the_least_separated_pair_decides() -> None:
    found = proposed([AMPLIFIER, SENSOR, LATE])
    assert set(found.separates) == {"amplifier_lag", "sensor_lag", "transport_delay"}
    assert "come apart least" in found.why


def test_what_no_voltage_separates_is_admitted_with_what_would() -> None:
    slight = AMPLIFIER.with_values({("amplifier_lag", "lag"): 1e-6})
    found = proposed([slight, SENSOR.with_values({("sensor_lag", "time_constant"): 1e-6})])
    assert found.separates == ()
    assert found.why.startswith("No voltage within reach tells amplifier lag from sensor lag")
    assert "measuring the voltage at the stack" in found.why


def test_a_pair_that_stays_alike_does_not_hide_one_that_can_be_told() -> None:
    twin = AMPLIFIER.with_values({("amplifier_lag", "lag"): 2.0001e-3})
    found = proposed([AMPLIFIER, twin, PAPER])
    assert found.why.startswith("Record ")
    assert "It will hardly tell" in found.why


def test_what_makes_no_difference_is_not_said_to_be_told_apart() -> None:
    """A delay that the voltage does not show stays possible beside the creep."""
    both = CREEP.with_link("transport_delay", delay=1e-6)
    found = proposed([CREEP, both, PAPER])
    assert "It will hardly tell creep from" in found.why
    assert found.separates == ("creep",)


def test_pairs_that_no_voltage_separates_are_admitted_at_once() -> None:
    slight = AMPLIFIER.with_values({("amplifier_lag", "lag"): 1e-6})
    late = LATE.with_values({("transport_delay", "delay"): 1e-6})
    found = proposed([slight, late, PAPER])
    assert found.why.startswith(
        "No voltage within reach tells amplifier lag from transport delay or amplifier lag from a "
        "mere refit or transport delay from a mere refit ("
    )
    assert "times the noise between them at most); sampling faster would tell." in found.why


def test_at_rest_nothing_is_asked_of_the_controller() -> None:
    drifting = PAPER.with_link("thermal_drift")
    slow = recorded(own=lambda t: 1e-7 * np.sin(2.0 * np.pi * 0.02 * t))
    found = proposed([drifting, PAPER], slow)
    assert np.ptp(found.voltage) == 0.0
    assert "at rest" in found.why
    assert "voltage_rate" not in found.why


def test_a_drift_that_all_have_tells_none_of_them() -> None:
    """Its course, over another time, is no spline of theirs, whichever of them is right."""
    drifting = PAPER.with_link("thermal_drift")
    slow = recorded(own=lambda t: 1e-6 * np.sin(2.0 * np.pi * 0.1 * t))
    found = proposed([drifting.with_link("amplifier_lag", lag=1e-6), drifting], slow)
    assert found.why.startswith("No voltage within reach tells amplifier lag from a mere refit")
    assert "less than 0.01 times the noise between them" in found.why


def test_a_hum_is_known_by_not_answering() -> None:
    humming = recorded(own=lambda t: 1e-7 * np.sin(2.0 * np.pi * 50.0 * t))
    resonance = PAPER.with_link("extra_resonance", frequency=50.0, share=0.05)
    found = proposed([HUM, resonance], humming)
    assert set(found.separates) == {"mains_hum", "extra_resonance"}


@pytest.mark.parametrize(("low", "high"), [(0.0, 160.0), (20.0, 60.0)])
@pytest.mark.parametrize("rivals", [[CREEP, PAPER], [AMPLIFIER, SENSOR], [FRICTION, PLAY]])
def test_it_stays_within_the_voltage_that_was_recorded(
    low: float, high: float, rivals: list[Model]
) -> None:
    recording = recorded(low=low, high=high)
    found = proposed(rivals, recording)
    assert low <= np.min(recording.voltage) <= np.min(found.voltage)
    assert np.max(found.voltage) <= np.max(recording.voltage) <= high


def test_it_never_shakes_the_rig_further_than_it_has_moved() -> None:
    """A lightly damped mode in the band of the chirp would ring to several strokes."""
    ringing = PAPER.with_link("extra_resonance", share=1.0, frequency=60.0, damping=0.005)
    recording = recorded(model=ringing)
    found = proposed([ringing, PAPER], recording)
    moved = simulate(ringing, found.voltage, PERIOD)
    assert np.ptp(moved) <= 1.3 * np.ptp(recording.measured)


@pytest.mark.parametrize("period", [5e-3, 1e-3, 5e-5])
def test_it_is_short(period: float) -> None:
    found = proposed([CREEP, PAPER], recorded(period))
    assert found.sample_period == period
    assert len(found.voltage) <= 40_000
    assert len(found.voltage) * period <= 20.0 + 1e-9


@pytest.mark.parametrize("hold", list(Hold))
def test_it_works_under_every_hold(hold: Hold) -> None:
    found = next_experiment([CREEP, PAPER], recorded(), Conditions(hold), NOISE)
    assert found
    steepest = np.max(np.abs(np.diff(found.voltage)))
    assert (steepest > 100.0) == (hold is Hold.ZERO)  # a smooth voltage has no jumps


def test_it_is_deterministic() -> None:
    rivals, recording = [FRICTION, MEMORY, PLAY], recorded()
    first, second = (proposed(rivals, recording) for _ in range(2))
    assert second.why == first.why
    np.testing.assert_array_equal(second.voltage, first.voltage)


def test_it_is_found_with_few_simulations(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a refit could do is linearised: one more for each parameter that may give way."""
    voltages = []

    def counted(model: Model, voltage: Array, sample_period: float, **more: Any) -> Array:  # noqa: ANN401
        voltages.append(voltage)
        return simulate(model, voltage, sample_period, **more)

    rivals = [AMPLIFIER, SENSOR, CREEP]
    shapes = sum(
        registry()[link].parameter(name).vanishing is None
        for rival in rivals
        for link, name in fitted_keys(rival, rival.effects)
    )
    monkeypatch.setattr(rehearsal, "simulate", counted)
    proposed(rivals)
    plain_and_its_h = 2
    each = len(rivals) + plain_and_its_h + len(BASE) + shapes
    tried = {voltage.tobytes() for voltage in voltages}
    assert len(tried) > 10
    assert len(voltages) <= each * len(tried)


def test_a_rival_that_contains_the_other_is_the_one_taken_as_true() -> None:
    reach = Reach(0.0, 160.0, PERIOD, 4000)
    rivals = rivals_of([PAPER, CREEP], recorded(), ZERO)
    for excitation in excitations(reach):
        rehearsed = Rehearsal.of(rivals, excitation.voltage, PERIOD, Hold.ZERO)
        assert rehearsed.separations()[0, 1].true == 1


@pytest.mark.parametrize("samples", [100, 4000, 40_000])
def test_every_excitation_fills_its_range_and_begins_gently(samples: int) -> None:
    reach = Reach(-30.0, 90.0, 1e-3, samples)
    for excitation in excitations(reach):
        voltage = excitation.voltage
        assert np.all(np.isfinite(voltage))
        assert np.min(voltage) >= -30.0
        assert np.max(voltage) <= 90.0
        assert abs(voltage[1] - voltage[0]) < 0.15 * 120.0
        assert len(voltage) <= samples


def diagnosis(experiment: NextExperiment | None) -> Diagnosis:
    """A diagnosis with nothing in it but what to record next."""
    return Diagnosis(
        verdict=UNKNOWN,
        sentence="",
        effects=(),
        candidates=(),
        stages={},
        gap=Gap(
            *[NOISE] * 4, closed=0.0, closed_low=0.0, closed_high=0.0, free_form=0.0, separate=False
        ),
        where=(),
        ambiguous=(),
        next_experiment=experiment,
        nominal=PAPER,
        refit=PAPER,
        model=PAPER,
        conditions=ZERO,
        judged=(),
        shares={},
    )


@pytest.mark.parametrize("rivals", [[CREEP, PAPER], [AMPLIFIER, SENSOR]])
def test_its_file_is_a_recording_that_only_lacks_the_answer(
    tmp_path: Path, rivals: list[Model]
) -> None:
    found = proposed(rivals)
    write_result(diagnosis(found), tmp_path)
    entry = json.loads((tmp_path / RESULT).read_text())["next_experiment"]
    path = tmp_path / NEXT_EXPERIMENT
    assert entry == {
        "why": found.why,
        "separates": list(found.separates),
        "voltage_csv": str(path),
    }
    header, *rows = path.read_text().splitlines()
    assert header == "time_s,voltage_V"
    assert rows[0].startswith("0.0")
    read = read_recording(path, Mapping.parse([]), needs_displacement=False)
    assert read.sample_period == pytest.approx(PERIOD, rel=1e-9)
    np.testing.assert_array_equal(read.voltage, found.voltage)
    low, high = PAPER.voltage_range
    assert low <= read.voltage.min() < read.voltage.max() <= high
    assert max(read.voltage[[0, -1]]) - low < 0.01 * (high - low)  # it begins and ends near rest


def test_a_voltage_that_answered_another_question_does_not_stay(tmp_path: Path) -> None:
    write_result(diagnosis(proposed([CREEP, PAPER])), tmp_path)
    write_result(diagnosis(None), tmp_path)
    assert json.loads((tmp_path / RESULT).read_text())["next_experiment"] is None
    assert not (tmp_path / NEXT_EXPERIMENT).exists()
