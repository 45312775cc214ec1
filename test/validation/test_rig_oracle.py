"""The oracle's fit, and the search for a strength."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rig_runs import DATASHEET, PAPER, STEPS, applied, lively, reading, rms

from microgripper_control.validation.drive import Drive
from microgripper_control.validation.law import Taken
from microgripper_control.validation.least_squares import minimise
from microgripper_control.validation.machine import Applied, Rig
from microgripper_control.validation.oracle import errors_known, explain
from microgripper_control.validation.strengths import excess, search, wanted_ratio

NOISE = 15e-9
FACTORS = {"d": 1.1, "alpha": 0.9, "beta": 1.12, "gamma": 0.95}
TRUE = PAPER.base.scaled(FACTORS)


def taken(name: str, samples: int, seed: int, effects: tuple[Applied, ...] = ()) -> Taken:
    past = 300
    drive = lively(samples + past, past=past)
    x = reading(Rig(TRUE, PAPER.scale, effects), drive, STEPS, NOISE, seed)
    return Taken(name, drive, x + 2e-6, (seed,))


def recordings(*effects: Applied) -> list[Taken]:
    return [taken("recording_1", 4000, 1, effects), taken("heldout_1", 3000, 2, effects)]


def test_planted_parameters_come_back_and_leave_the_noise() -> None:
    found = explain(recordings(), PAPER.scale, NOISE)
    for name in FACTORS:
        assert getattr(found.rig.base, name) == pytest.approx(getattr(TRUE, name), rel=0.02)
    assert found.errors["heldout"] == pytest.approx(NOISE, rel=0.03)


def test_an_effect_leaves_more_without_its_law_and_the_noise_with_it() -> None:
    made = applied("saturation", "a", 0.25)
    data = recordings(made)
    without = explain(data, PAPER.scale, NOISE).errors
    start = applied("saturation", "a", 0.2)
    with_it = explain(data, PAPER.scale, NOISE, [start], steps=16)
    assert without["heldout"] > 5.0 * NOISE
    assert with_it.errors["heldout"] == pytest.approx(NOISE, rel=0.04)
    assert with_it.rig.effects[0].strength == pytest.approx(0.25, rel=0.02)
    known = errors_known(data, Rig(TRUE, PAPER.scale, (made,)), NOISE, STEPS)
    assert known["all"] == pytest.approx(NOISE, rel=0.03)


@pytest.mark.parametrize(
    ("step", "left"),
    [
        (2.0, math.hypot(1.0, 2.0 / math.sqrt(12.0))),  # dithered: a noise of its own
        (40.0, math.sqrt(40.0 / math.sqrt(math.pi))),  # noise tells near thresholds alone
    ],
)
def test_a_converter_leaves_its_oracle_more_than_the_noise(step: float, left: float) -> None:
    rig = Rig(TRUE, PAPER.scale, (applied("sensor_quantization", "a", step * NOISE),))
    data = [taken(name, 6000, 1, rig.effects) for name in ("recording_1", "heldout_1")]
    known = errors_known(data, rig, NOISE, STEPS)["all"]
    assert known == pytest.approx(left * NOISE, rel=0.1)
    refit = explain(data, PAPER.scale, NOISE).errors["all"]
    assert refit == pytest.approx(NOISE * math.hypot(1.0, step / math.sqrt(12.0)), rel=0.1)


def test_the_stiffnesses_show_only_through_what_is_fitted() -> None:
    base = DATASHEET.base.scaled({"k": 1.15, "k_s": 0.86, "m": 0.9, "d": 1.1})
    drive = lively(2000, DATASHEET)
    seen = base.equivalent(DATASHEET.base)
    assert (seen.k, seen.k_s) == (DATASHEET.base.k, DATASHEET.base.k_s)
    one, other = (reading(Rig(b, DATASHEET.scale), drive) for b in (base, seen))
    assert one == pytest.approx(other, rel=1e-9, abs=1e-15)


def test_the_nominal_numbers_are_taken_as_they_are_without_iterations() -> None:
    found = explain(recordings(), PAPER.scale, NOISE, iterations=0)
    assert found.rig.base == PAPER.base
    assert found.errors["all"] > 10.0 * NOISE


def test_a_wrong_initial_hysteresis_belongs_to_the_recording() -> None:
    fresh = taken("recording_1", 4000, 1)
    forgotten = fresh.drive.samples.copy()
    forgotten[: fresh.drive.past_samples] = forgotten[fresh.drive.past_samples - 1]
    blind = Taken("recording_1", Drive(1e-3, 300, forgotten), fresh.measured, (1,))
    other = Taken("heldout_1", blind.drive, blind.measured, (1,))
    found = explain([blind, other], PAPER.scale, NOISE)
    assert found.errors["heldout"] == pytest.approx(NOISE, rel=0.1)


def test_least_squares_stops_at_a_bound_and_ignores_what_shows_nothing() -> None:
    def residual(z: np.ndarray) -> np.ndarray:
        return np.array([z[0] - 3.0, 2.0 * (z[1] - 0.5), 0.0])

    def jacobian(z: np.ndarray, r: np.ndarray) -> np.ndarray:
        return np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]])

    found = minimise(residual, jacobian, np.full(3, 0.1), np.zeros(3), np.ones(3), 50, 1e-9)
    assert found == pytest.approx([1.0, 0.5, 0.1], abs=1e-3)


@pytest.mark.parametrize(
    "ratio",
    [
        lambda s: math.hypot(1.0, 40.0 * s),
        lambda s: math.hypot(1.0, max(s - 0.3, 0.0) * 100.0),
        lambda s: math.hypot(1.0, 1e4 * s**3),
        lambda s: math.hypot(1.0, 3.0 * math.tanh(s * 1e5) * s * 1e5),
    ],
)
@pytest.mark.parametrize("target", [1.5, 5.0])
def test_the_search_finds_the_strength_of_any_growing_ratio(ratio, target: float) -> None:  # noqa: ANN001
    found = search(ratio, 0.05, 10.0, target)
    assert found.reached
    assert ratio(found.strength) == pytest.approx(target, rel=0.03)


def test_the_search_takes_the_nearer_side_of_a_jump_and_says_so() -> None:
    found = search(lambda s: 1.0 if s < 0.7 else 4.0, 0.1, 10.0, 5.0)
    assert not found.reached
    assert found.ratio == 4.0
    weak = search(lambda s: math.hypot(1.0, 0.01 * s), 0.1, 10.0, 5.0)
    assert (weak.strength, weak.reached) == (10.0, False)


def test_excess_is_what_lies_beyond_the_noise() -> None:
    assert excess(1.0) == 0.0
    assert excess(0.98) == 0.0
    assert excess(wanted_ratio("medium")) == pytest.approx(math.sqrt(24.0))
    assert rms(np.array([3.0, 4.0])) == pytest.approx(math.sqrt(12.5))
