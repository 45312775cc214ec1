"""What belongs to a recording is found, and held-out blocks are never peeked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.identification.nuisance import (
    Conditions,
    Projection,
    blocks,
    fit_nuisance,
    heldout_prediction,
    predict,
    zero_of,
)
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

VOLTAGE = 80.0 - 75.0 * np.cos(2.0 * np.pi * np.arange(3000) / 1000.0)


def recording(h: float = 4e-7, offset: float = -1e-6) -> Recording:
    measured = simulate(
        nominal_model(), VOLTAGE, 1e-3, initial=Initial.FIRST_SAMPLE, initial_hysteresis=h
    )
    return Recording("run", 1e-3, VOLTAGE.copy(), measured + offset)


def test_offset_and_initial_hysteresis_are_found() -> None:
    found = fit_nuisance(nominal_model(), recording(), Conditions())
    assert found.initial_hysteresis == pytest.approx(4e-7, rel=1e-6)
    assert found.weights == pytest.approx((-1e-6,), rel=1e-6)


def test_a_small_loop_may_begin_with_what_a_large_one_has_built_up() -> None:
    full, small = np.linspace(0.0, 150.0, 301), 8.0 - 2.0 * np.sin(np.linspace(0.0, 9.0, 400))
    voltage = np.concatenate([full, full[::-1], small])
    measured = simulate(nominal_model(), voltage, 1e-3)
    piece = Recording("piece", 1e-3, small, measured[-len(small) :])
    found = fit_nuisance(nominal_model(), piece, Conditions())
    # No travel within the piece could build that much up; the way to its first sample is missing.
    assert abs(found.initial_hysteresis) > 0.0801 * 1.4447e-7 * 3.0 * np.max(small)
    predicted = predict(nominal_model(), piece, Conditions(), found)
    assert np.max(np.abs(predicted - piece.measured)[5:]) < 1e-9


def test_a_frozen_zero_is_left_alone() -> None:
    model = nominal_model().with_link("sensor_zero", offset=-1e-6)
    found = fit_nuisance(model, recording(), Conditions())
    assert zero_of(model, found) == 0.0
    assert found.initial_hysteresis == pytest.approx(4e-7, rel=1e-6)


def test_a_frozen_zero_is_not_taken_for_that_of_a_course() -> None:
    model = nominal_model().with_link("sensor_zero", offset=0.0).with_link("thermal_drift")
    drifted = recording(offset=0.0)
    drifting = replace(
        drifted, displacement=drifted.measured + 1e-6 * np.linspace(0.0, 1.0, len(VOLTAGE))
    )
    found = fit_nuisance(model, drifting, Conditions())
    assert abs(found.weights[0]) > 1e-8
    assert zero_of(model, found) == 0.0
    assert heldout_prediction(model, drifting, Conditions()).zero == 0.0


def test_only_what_the_voltage_explains_judges() -> None:
    """A brief recording answers to what came before it for a tenth of its length and more."""
    brief = Recording("brief", 1e-4, VOLTAGE, simulate(nominal_model(), VOLTAGE, 1e-4))
    conditions = Conditions()
    counted = heldout_prediction(nominal_model(), brief, conditions).counted
    assert not np.any(counted & ~conditions.answered(brief))
    assert not conditions.answered(brief)[:400].any()


def test_courses_that_are_nearly_one_take_no_more_than_they_show() -> None:
    """Creep slower than a recording is long: what its elements differ by is rounding."""
    time = 2e-3 * np.arange(10_000)
    noise = np.random.default_rng(4).standard_normal(len(time))

    def left(slower: float) -> np.ndarray:
        constants = 60.0 * slower * 10.0 ** np.linspace(0.0, 1.0, 8)
        decays = np.exp(-time / constants[:, None])
        return Projection.off(np.vstack([np.ones(len(time)), decays]))(noise)

    assert np.linalg.norm(left(1.0) - left(1.0 + 1e-6)) < 1e-5
    assert np.linalg.norm(noise - left(1.0)) < 6.0  # some three directions: each takes about one


def test_the_course_of_a_hum_and_a_drift_belongs_to_the_recording() -> None:
    clean = recording()
    time = 1e-3 * np.arange(len(clean))
    own = 3e-7 * np.sin(2.0 * np.pi * 50.0 * time + 1.1) + 4e-7 * time
    noisy = Recording("run", 1e-3, VOLTAGE.copy(), clean.measured + own)
    model = nominal_model().with_link("mains_hum", frequency=50.0).with_link("thermal_drift")
    prediction, counted, _ = heldout_prediction(model, noisy, Conditions())
    assert np.max(np.abs((noisy.measured - prediction)[counted])) < 2e-9


def test_readings_are_rounded_where_the_recording_has_its_grid() -> None:
    """The sensor rounds what it shows, hum included; where its steps lie, the tare decides."""
    step, tare = 3e-7, 1.1e-7
    clean = recording()
    hum = 2e-7 * np.sin(2.0 * np.pi * 50.0 * 1e-3 * np.arange(len(clean)) + 1.1)
    shown = tare + step * np.rint((clean.measured + hum) / step)
    coarse = Recording("run", 1e-3, VOLTAGE.copy(), shown)
    model = nominal_model().with_link("mains_hum", frequency=50.0)
    smooth, counted, _ = heldout_prediction(model, coarse, Conditions())
    rounded = heldout_prediction(
        model.with_link("sensor_quantization", resolution=step), coarse, Conditions()
    ).prediction
    off = (rounded - shown) / step
    assert np.allclose(off, np.rint(off), atol=1e-6)
    assert np.mean(np.abs(off[counted]) < 0.5) > 0.95
    assert np.std((smooth - shown)[counted]) == pytest.approx(step / np.sqrt(12.0), rel=0.1)


def test_a_course_that_died_away_unseen_gets_no_weight() -> None:
    """The first samples are not compared: creep of a few of them could be put there at will."""
    clean = recording()
    noise = np.random.default_rng(2).normal(0.0, 15e-9, len(clean))
    noisy = Recording("run", 1e-3, VOLTAGE.copy(), clean.measured + noise)
    model = nominal_model().with_link("creep", strength=1e-9, fastest=1.5e-3, slowest=10.0)
    found = fit_nuisance(model, noisy, Conditions())
    prediction = predict(model, noisy, Conditions(), found)
    assert np.max(np.abs(noisy.measured - prediction)) < 2e-7


def test_blocks_alternate_and_share_every_sample_once() -> None:
    odd, even = blocks(1003, odd=True), blocks(1003, odd=False)
    assert np.all(odd ^ even)
    assert odd[0]
    assert even[-1]
    assert np.count_nonzero(np.diff(odd)) == 9


def test_heldout_blocks_do_not_influence_their_prediction() -> None:
    clean = recording()
    spoiled = clean.measured.copy()
    counted = blocks(len(clean), odd=False)
    spoiled[counted] += 5e-7
    other = Recording("run", 1e-3, VOLTAGE.copy(), spoiled)
    first, mask, _ = heldout_prediction(nominal_model(), clean, Conditions())
    second = heldout_prediction(nominal_model(), other, Conditions()).prediction
    assert np.array_equal(first, second)
    assert np.array_equal(mask, counted)
    assert np.max(np.abs((clean.measured - first)[mask])) < 1e-12


@pytest.mark.parametrize("beta", [0.03, 0.06, 0.1])
def test_what_began_may_be_forgotten_within_a_few_samples(beta: float) -> None:
    model = nominal_model().with_values({("bouc_wen", "beta"): beta, ("bouc_wen", "gamma"): 0.0})
    voltage = np.where(np.arange(400) % 5 < 2, 0.0, 160.0)
    fast = Recording("fast", 1e-3, voltage, simulate(model, voltage, 1e-3) + 2e-6)
    nuisance = fit_nuisance(model, fast, Conditions())
    assert zero_of(model, nuisance) == pytest.approx(2e-6, abs=1e-8)
