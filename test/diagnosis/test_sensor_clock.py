"""The clock of a sensor found in recordings of a rig whose clock is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.search.sensor_clock import on_its_clocks, retimed
from microgripper_control.identification.fit import fit
from microgripper_control.identification.nuisance import (
    Conditions,
    blocks,
    fit_nuisance,
    heldout_prediction,
)
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD, NOISE = 1e-3, 10e-9  # s, m
AGE = 0.3  # of the clock


def recorded(rig: Model, seed: int) -> Recording:
    random = np.random.default_rng(seed)
    time = PERIOD * np.arange(9000)
    waves = [np.sin(2.0 * np.pi * (f * time + random.random())) for f in (0.7, 2.3, 5.1)]
    voltage = 80.0 + 25.0 * np.sum(waves, axis=0)
    age = AGE * rig.clock
    displacement = simulate(
        rig, voltage, PERIOD, initial=Initial.FIRST_SAMPLE, reading_age=age
    ) + NOISE * random.normal(size=len(time))
    return Recording(f"seed {seed}", PERIOD, voltage, displacement)


def explained_by_a_lag(recordings: list[Recording], averaging: float) -> tuple[Evidence, Trial]:
    evidence = Evidence.gather(recordings, [], Conditions(), nominal_model())
    model = nominal_model().with_link("sensor_lag", averaging=averaging, time_constant=0.0)
    return evidence, Trial(model, (), tuple(0.0 for _ in recordings), 0.0)


@pytest.mark.parametrize("clock", [1.37e-3, 6.43e-3, 23.1e-3])
def test_a_clock_and_the_ages_of_readings_are_found(clock: float) -> None:
    lag = {"averaging": 4.0 * clock, "time_constant": 0.0}
    rig = nominal_model().with_link("sensor_lag", **lag, clock=clock)
    recordings = [recorded(rig, 1), recorded(rig, 2)]
    (evidence, ahead), *_ = on_its_clocks(*explained_by_a_lag(recordings, 5.0 * clock))
    assert ahead == pytest.approx(0.5 * clock, abs=0.02 * clock)
    assert evidence.scales.clock == pytest.approx(clock, rel=1e-4)
    for recording in evidence.fitted:
        off = (recording.reading_age - AGE * clock) / clock
        assert abs(off - round(off)) * clock < 0.1 * PERIOD + 0.02 * clock
    prediction, counted, _ = heldout_prediction(rig, recordings[0], Conditions())
    assert np.std((recordings[0].measured - prediction)[counted]) < 1.2 * NOISE


def test_a_clock_is_found_more_closely_with_a_lag_that_has_it() -> None:
    clock = 2.3e-3
    rig = nominal_model().with_link("sensor_lag", averaging=9.2e-3, time_constant=0.0, clock=clock)
    recordings = [recorded(rig, 7), recorded(rig, 8)]
    evidence, trial = explained_by_a_lag(recordings, 9e-3)
    rough = evidence.clocked((1.0 + 2e-5) * clock, [0.8 * AGE * clock, 1.2 * AGE * clock])
    model = trial.model.with_link("sensor_lag", clock=rough.scales.clock)
    closer, _ = retimed(rough, replace(trial, model=model))
    assert closer.scales.clock == pytest.approx(clock, rel=3e-6)
    for recording in closer.fitted:
        assert recording.reading_age == pytest.approx(AGE * clock, abs=0.03 * clock)


def test_without_a_clock_none_is_found() -> None:
    rig = nominal_model().with_link("sensor_lag", averaging=12e-3, time_constant=3e-3)
    evidence, trial = explained_by_a_lag([recorded(rig, 3)], 15e-3)
    assert on_its_clocks(evidence, trial) == []


@pytest.mark.parametrize("samples", [100, 300])
def test_few_samples_are_too_few_for_a_clock(samples: int) -> None:
    whole = recorded(nominal_model().with_link("sensor_lag", averaging=5e-3, time_constant=0.0), 6)
    voltage, displacement = whole.voltage[:samples], whole.measured[:samples]
    short = Recording("short", PERIOD, voltage, displacement)
    evidence, trial = explained_by_a_lag([short], 6e-3)
    assert on_its_clocks(evidence, trial) == []


def test_a_clock_of_the_model_itself_is_read_in_time() -> None:
    lag = {"averaging": 10e-3, "time_constant": 0.0}
    rig = nominal_model().with_link("sensor_lag", **lag, clock=7e-3)
    recording = recorded(rig, 4)
    nuisance = fit_nuisance(rig, recording, Conditions(), blocks(len(recording), odd=True))
    assert nuisance.reading_age == pytest.approx(AGE * 7e-3, abs=0.2e-3)


def test_a_model_with_a_clock_is_fitted_in_time() -> None:
    lag = {"averaging": 10e-3, "time_constant": 0.0}
    rig = nominal_model().with_link("sensor_lag", **lag, clock=7e-3)
    strange = rig.with_values({("bouc_wen", "d"): 1.03 * rig.value("bouc_wen", "d")})
    found = fit(strange, [recorded(rig, 5)], Conditions())
    assert found.rmse[0] < 1.1 * NOISE
    assert found.gain.value == pytest.approx(fit(rig, [recorded(rig, 5)]).gain.value, rel=1e-3)
