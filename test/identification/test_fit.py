"""Identification against planted truths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.identification.confidence import interval
from microgripper_control.identification.determined import spread
from microgripper_control.identification.fit import Fit, fit
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.search import descend
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, Setting, nominal_model
from microgripper_control.plant.simulate import Initial, simulate

NOISE = 15e-9
NAMES = ("d", "alpha", "beta", "gamma")


def growing_loops(samples: int, period: float = 1e-3) -> Array:
    time = period * np.arange(samples)
    return 80.0 * (1.0 - np.cos(2.0 * np.pi * time)) * (0.2 + 0.8 * time / time[-1])


def record(
    model: Model, voltage: Array, seed: int, period: float = 1e-3, offset: float = 3e-6
) -> Recording:
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(voltage))
    measured = simulate(model, voltage, period) + noise + offset
    return Recording("run", period, voltage.copy(), measured)


def mistuned(model: Model, *factors: float) -> Model:
    return model.with_values(
        {
            ("bouc_wen", name): factor * model.value("bouc_wen", name)
            for name, factor in zip(NAMES, factors, strict=True)
        }
    )


def error(found: Fit, truth: Model, name: str) -> float:
    value = truth.value("bouc_wen", name)
    return abs(found.model.value("bouc_wen", name) / value - 1.0)


def test_planted_parameters_come_back_within_a_quarter_per_cent() -> None:
    truth = nominal_model()
    found = fit(mistuned(truth, 0.9, 1.1, 0.9, 1.1), [record(truth, growing_loops(40_000), 1)])
    assert all(error(found, truth, name) < 2.5e-3 for name in NAMES)
    assert found.gain.value == pytest.approx(1.4447e-7 * 5e7 / (5e7 + 8.2e5), rel=2.5e-3)
    assert found.rmse[0] == pytest.approx(NOISE, rel=0.03)
    assert found.nuisances[0].weights[0] == pytest.approx(3e-6, abs=2e-9)


def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    truth = nominal_model()
    voltage = growing_loops(4000)
    clean = simulate(truth, voltage, 1e-3)
    start = mistuned(truth, 0.9, 1.1, 0.9, 1.1)
    seeds, hits = 200, dict.fromkeys(NAMES, 0)
    for seed in range(1000, 1000 + seeds):
        noise = NOISE * np.random.default_rng(seed).standard_normal(len(voltage))
        found = fit(start, [Recording("run", 1e-3, voltage.copy(), clean + noise)])
        for name in NAMES:
            ends = found.model.settings["bouc_wen"][name].interval
            assert ends is not None
            hits[name] += ends[0] <= truth.value("bouc_wen", name) <= ends[1]
    assert all(0.90 <= count / seeds <= 0.98 for count in hits.values()), hits


@pytest.mark.parametrize("noise", [(300e-9, 10e-9), (60e-9, 15e-9), (15e-9, 15e-9)])
def test_intervals_cover_the_truth_where_recordings_differ_in_noise(
    noise: tuple[float, float],
) -> None:
    """A recording of the whole stroke tells more than a longer one of little of it."""
    truth, seeds, hits = nominal_model(), 60, dict.fromkeys(NAMES, 0)
    keys = tuple(("bouc_wen", name) for name in NAMES)
    voltages = growing_loops(1000), growing_loops(4000) / 8.0
    clean = [simulate(truth, voltage, 1e-3) for voltage in voltages]
    for seed in range(2000, 2000 + seeds):
        random = np.random.default_rng(seed)
        recordings = [
            Recording("run", 1e-3, u.copy(), x + size * random.standard_normal(len(u)))
            for u, x, size in zip(voltages, clean, noise, strict=True)
        ]
        problem = Problem(truth, recordings, Conditions(initial=Initial.REST), keys)
        planted = problem.point(truth, [])
        z = descend(problem, planted)
        found = spread(problem, z)
        for index, name in enumerate(NAMES):
            variance, freedom = float(found.variances[index]), float(found.freedom[index])
            low, high = interval(float(z[index]), variance, freedom)
            hits[name] += low <= planted[index] <= high
    assert all(count / seeds >= 0.88 for count in hits.values()), hits


def test_what_cannot_be_seen_stays_nominal_and_is_named() -> None:
    truth = nominal_model()
    found = fit(truth, [record(truth, growing_loops(4000), 2)])
    named = {entry.key for entry in found.undetermined}
    assert named == {("second_order", name) for name in ("m", "b", "k", "k_s")}
    assert found.model.values("second_order") == truth.values("second_order")


def test_a_fast_recording_determines_mass_and_damping() -> None:
    truth = nominal_model()
    steps = 80.0 + 60.0 * np.sign(np.sin(2.0 * np.pi * 500.0 * 1e-5 * np.arange(6000)))
    start = truth.with_values({("second_order", "m"): 0.0042, ("second_order", "b"): 130.0})
    conditions = Conditions(initial=Initial.REST)
    found = fit(start, [record(truth, steps, 3, period=1e-5)], conditions)
    assert found.model.value("second_order", "m") == pytest.approx(0.0038, rel=2e-3)
    assert found.model.value("second_order", "b") == pytest.approx(150.0, rel=1e-2)


def test_samples_that_were_filled_in_do_not_count() -> None:
    truth = nominal_model()
    whole = record(truth, growing_loops(8000), 10)
    read = np.ones(len(whole), bool)
    for start in range(200, 7800, 400):
        read[start : start + 60] = False
    filled = np.interp(whole.time, whole.time[read], whole.measured[read])
    holed = Recording("holed", 1e-3, whole.voltage.copy(), filled, recorded=read)
    found = fit(mistuned(truth, 1.1, 0.9, 1.1, 0.9), [holed])
    assert all(error(found, truth, name) < 1e-2 for name in NAMES)
    assert found.rmse[0] == pytest.approx(NOISE, rel=0.05)


def test_a_recording_that_starts_anywhere_has_its_own_initial_hysteresis() -> None:
    truth = nominal_model()
    whole = record(truth, growing_loops(12_000), 4)
    late = slice(5300, None)
    part = Recording("late", 1e-3, whole.voltage[late].copy(), whole.measured[late].copy())
    found = fit(mistuned(truth, 1.1, 0.9, 1.1, 0.9), [part])
    assert all(error(found, truth, name) < 1e-2 for name in NAMES)
    assert abs(found.nuisances[0].initial_hysteresis) > 1e-7


def test_several_recordings_share_the_rig_but_not_the_zero() -> None:
    truth = nominal_model()
    runs = [record(truth, growing_loops(6000), 5, offset=-2e-6)]
    runs.append(record(truth, 160.0 - growing_loops(6000), 6, offset=7e-6))
    found = fit(mistuned(truth, 1.1, 1.1, 0.9, 0.9), runs)
    assert all(error(found, truth, name) < 1e-2 for name in NAMES)
    assert [n.weights[0] for n in found.nuisances] == pytest.approx([-2e-6, 7e-6], abs=3e-8)


def test_a_very_different_actuator_is_found_from_the_papers_values() -> None:
    far = {"d": 1.8e-7, "alpha": 0.38, "beta": 5e-3, "gamma": 1.7e-3}
    truth = nominal_model().with_values({("bouc_wen", k): v for k, v in far.items()})
    voltage = 150.0 * np.sin(2.0 * np.pi * 1e-3 * np.arange(6000)) * np.linspace(0.3, 1.0, 6000)
    found = fit(nominal_model(), [record(truth, voltage, 7)])
    assert all(error(found, truth, name) < 2e-2 for name in NAMES)


def test_other_holds_and_a_periodic_start() -> None:
    truth = nominal_model()
    voltage = 80.0 + 70.0 * np.sin(2.0 * np.pi * np.arange(2000) / 500.0)
    conditions = Conditions(Hold.FIRST, Initial.PERIODIC)
    measured = simulate(truth, voltage, 1e-3, hold=Hold.FIRST, initial=Initial.PERIODIC)
    found = fit(
        mistuned(truth, 0.95, 1.05, 0.95, 1.05),
        [Recording("period", 1e-3, voltage, measured)],
        conditions,
    )
    assert found.rmse[0] < 1e-11


def test_frozen_parameters_stay() -> None:
    truth = nominal_model()
    frozen = truth.with_settings({("bouc_wen", "alpha"): Setting(0.09, frozen=True)})
    found = fit(frozen, [record(truth, growing_loops(4000), 8)])
    assert found.model.value("bouc_wen", "alpha") == 0.09
    assert ("bouc_wen", "alpha") not in found.determined


def test_a_delay_is_fitted_as_a_fraction_of_a_sample() -> None:
    truth = nominal_model().with_link("transport_delay", delay=2.0e-3)
    voltage = growing_loops(6000)
    start = nominal_model().with_link("transport_delay", delay=2.4e-3)
    measured = simulate(truth, voltage, 1e-3, hold=Hold.FIRST)
    noise = NOISE * np.random.default_rng(9).standard_normal(len(voltage))
    found = fit(start, [Recording("late", 1e-3, voltage, measured + noise)], Conditions(Hold.FIRST))
    assert found.model.value("transport_delay", "delay") == pytest.approx(2.0e-3, rel=5e-3)


@pytest.mark.parametrize("still", ["voltage", "displacement"])
def test_a_recording_that_never_moves_is_refused(still: str) -> None:
    moving = np.linspace(0.0, 100.0, 100)
    voltage = np.zeros(100) if still == "voltage" else moving
    measured = np.zeros(100) if still == "displacement" else moving * 1e-7
    with pytest.raises(MicrogripperError, match="never changes"):
        fit(nominal_model(), [Recording("still", 1e-3, voltage, measured)])


@pytest.mark.parametrize(("frequency", "damping"), [(1300.0, 0.17), (1300.0, 0.03), (4000.0, 0.1)])
@pytest.mark.parametrize("sweep", [False, True])
def test_a_resonance_far_from_the_models_is_found(
    frequency: float, damping: float, *, sweep: bool
) -> None:
    """The paper's actuator resonates at 18 kHz, the maker's figures say 1.3 kHz."""
    period, count = 1e-4, 3000
    nominal = nominal_model()
    springs = nominal.value("second_order", "k") + nominal.value("second_order", "k_s")
    omega = 2.0 * np.pi * frequency
    m = springs / omega**2
    planted = {("second_order", "m"): m, ("second_order", "b"): 2.0 * damping * m * omega}
    time = period * np.arange(count)
    if sweep:
        voltage = 70.0 + 60.0 * np.sin(2.0 * np.pi * (5.0 + 4000.0 * time) * time)
    else:
        voltage = np.repeat(np.random.default_rng(8).uniform(0.0, 140.0, 30), 100)
    rig = mistuned(nominal, 1.1, 0.95, 1.05, 0.9).with_values(planted)
    found = fit(nominal, [record(rig, voltage, 9, period)])
    for key, value in planted.items():
        assert found.model.value(*key) == pytest.approx(value, rel=0.02), key
    assert found.rmse[0] < 1.1 * NOISE
    assert not found.undetermined or all(u.key[1] not in "mb" for u in found.undetermined)


def test_a_nominal_value_that_diverges_beside_those_found_is_not_returned_to() -> None:
    """The actuator of the maker's figures moves seven times as far: no error, whatever is found."""
    rig = nominal_model().with_values({("bouc_wen", "d"): 9.9543e-07})
    time = 1e-4 * np.arange(3000)
    voltage = 70.0 + 60.0 * np.sin(2.0 * np.pi * (5.0 + 4000.0 * time) * time)
    heavy = rig.with_values({("second_order", "m"): 0.5, ("second_order", "b"): 60.0})
    found = fit(nominal_model(), [record(heavy, voltage, 10, 1e-4)])
    assert np.isfinite(found.rmse[0])


def test_what_a_model_lacks_leaves_few_independent_samples() -> None:
    recordings = [record(nominal_model().with_link("creep"), growing_loops(2000), 11)]
    keys = [("bouc_wen", name) for name in NAMES]
    problem = Problem(nominal_model(), recordings, Conditions(), tuple(keys))
    white = replace(problem, recordings=[record(nominal_model(), growing_loops(2000), 12)])
    z = problem.point(problem.model, [0.0])
    assert np.all(spread(problem, z).freedom < 100.0)
    assert np.all(spread(white, z).freedom > 1500.0)
