"""Lags of a rig whose sensor converts on a clock of its own, tried on the clock they show."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import base_of
from microgripper_control.diagnosis.search.clocked_lags import on_the_sensors_clock
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.diagnosis.search.rounds import play
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD, NOISE = 2e-3, 10e-9  # s, m
LAGS = ("sensor_lag", "transport_delay")


def tried(rig: Model, nominal: Model, other: float = PERIOD) -> Pool:
    """Both lags tried by themselves, without a clock, on two recordings of a rig.

    `other` is the sample period of the second, s.
    """
    random = np.random.default_rng(5)
    recordings = []
    for age, period in ((0.2 * rig.clock, PERIOD), (0.7 * rig.clock, other)):
        time = period * np.arange(4000)
        waves = [np.sin(2.0 * np.pi * (f * time + random.random())) for f in (0.7, 2.3, 7.1)]
        voltage = 80.0 + 25.0 * np.sum(waves, axis=0)
        clean = simulate(rig, voltage, period, initial=Initial.FIRST_SAMPLE, reading_age=age)
        noisy = clean + NOISE * random.normal(size=len(time))
        recordings.append(Recording(f"age {age}", period, voltage, noisy))
    evidence = Evidence.gather(recordings, [], Conditions(), nominal)
    before = nominal_trial(evidence, nominal)
    pool = Pool(evidence, before, refit_trial(evidence, before))
    names = [name for name in LAGS if name not in nominal.effects]
    play(evidence, [base_of(evidence, pool.refit)], names, len(names), pool, jobs=1)
    return pool


@pytest.mark.parametrize(("clock", "averaged"), [(0.93e-3, 4), (2.7e-3, 4), (0.93e-3, 12)])
def test_an_average_is_found_on_its_clock(clock: float, averaged: int) -> None:
    lag = {"averaging": averaged * clock, "time_constant": 0.0}
    rig = nominal_model().with_link("sensor_lag", **lag, clock=clock)
    pool = tried(rig, nominal_model())
    assert pool.best(1, 1)[0].rmse > 2.0 * NOISE
    timed = on_the_sensors_clock(pool, jobs=1)
    best = timed.best(1, 1)[0]
    assert best.effects == ("sensor_lag",)
    assert best.rmse < 1.2 * NOISE
    assert best.model.value("sensor_lag", "clock") == pytest.approx(clock, rel=1e-4)
    behind = registry()["sensor_lag"].behind
    mean = behind(rig.values("sensor_lag"))
    assert behind(best.model.values("sensor_lag")) == pytest.approx(mean, rel=0.02)
    assert pool.evidence.scales.clock == 0.0  # the pool it began with is as it was


def test_a_delay_is_found_that_only_few_readings_show() -> None:
    """Just under a sample: few readings show the step before, and one misjudged counts for ten."""
    delay = {"delay": 1.72e-3, "clock": 0.3113e-3}
    pool = tried(nominal_model().with_link("transport_delay", **delay), nominal_model())
    assert pool.best(1, 1)[0].rmse > 4.0 * NOISE
    best = on_the_sensors_clock(pool, jobs=1).best(1, 1)[0]
    assert best.effects == ("transport_delay",)
    assert best.fitted_rmse < 1.3 * NOISE
    assert best.rmse < 2.2 * NOISE
    assert best.model.value("transport_delay", "clock") == pytest.approx(delay["clock"], rel=1e-4)
    assert best.model.value("transport_delay", "delay") == pytest.approx(1.72e-3, abs=0.05e-3)


def test_recordings_may_have_sample_periods_of_their_own() -> None:
    lag = {"averaging": 3.72e-3, "time_constant": 0.0, "clock": 0.93e-3}
    pool = tried(nominal_model().with_link("sensor_lag", **lag), nominal_model(), other=1.37e-3)
    best = on_the_sensors_clock(pool, jobs=1).best(1, 1)[0]
    assert best.rmse < 1.2 * NOISE
    assert best.model.value("sensor_lag", "clock") == pytest.approx(lag["clock"], rel=1e-4)


def test_without_a_clock_nothing_changes() -> None:
    rig = nominal_model().with_link("sensor_lag", averaging=7e-3, time_constant=2e-3)
    pool = tried(rig, nominal_model())
    assert on_the_sensors_clock(pool, jobs=1) is pool


def test_a_clock_that_the_model_has_is_not_looked_for() -> None:
    known = nominal_model().with_link("sensor_lag", averaging=5e-3, time_constant=0.0, clock=3e-3)
    pool = tried(known.with_link("transport_delay", delay=4.3e-3), known)
    assert on_the_sensors_clock(pool, jobs=1) is pool


def test_a_clock_may_show_only_beside_another_effect() -> None:
    lag = {"averaging": 3.72e-3, "time_constant": 0.0, "clock": 0.93e-3}
    rig = nominal_model().with_link("sensor_lag", **lag).with_link("creep", strength=0.05)
    pool = tried(rig, nominal_model())
    assert on_the_sensors_clock(pool, jobs=1) is pool
    leader = pool.tried[frozenset(["sensor_lag"])]
    play(pool.evidence, [base_of(pool.evidence, leader)], ["creep"], 1, pool, jobs=1)
    best = on_the_sensors_clock(pool, jobs=1, size=2).best(2, 1)[0]
    assert best.rmse < 1.2 * NOISE
    assert best.model.value("sensor_lag", "clock") == pytest.approx(lag["clock"], rel=1e-4)
