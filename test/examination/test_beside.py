"""What a user would do instead, on planted effects."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.effects.registry import registry
from microgripper_control.examination.beside import grey_box
from microgripper_control.examination.beside.black_box import shrink
from microgripper_control.examination.beside.compare import METHODS, compare
from microgripper_control.examination.beside.evidence import Begun, Rest
from microgripper_control.examination.beside.sparse import TERMS, regress, stlsq
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD, NOISE = 5e-3, 10e-9


def recorded(rig: Model, seed: int) -> Recording:
    rng = np.random.default_rng(seed)
    steps = np.repeat(rng.uniform(10.0, 150.0, 8), 150)
    t = PERIOD * np.arange(1500)
    loops = 75.0 * (1.0 - np.cos(2.0 * np.pi * 0.7 * t))
    voltage = np.concatenate([loops, steps])
    moved = simulate(rig, voltage, PERIOD) + NOISE * rng.standard_normal(len(voltage))
    return Recording(f"run {seed}", PERIOD, voltage, moved)


def begun_with(rig: Model) -> Begun:
    nominal = nominal_model()
    evidence = Evidence.gather([recorded(rig, 1)], [recorded(rig, 2)], Conditions(), nominal)
    before = nominal_trial(evidence, nominal)
    return Begun(evidence, before, refit_trial(evidence, before))


@pytest.fixture(scope="module")
def softening() -> Begun:
    rig = nominal_model().with_values({("bouc_wen", "d"): 1.5e-7})
    return begun_with(rig.with_link("nonlinear_stiffness", cubic=2e15))


def test_the_planted_effect_has_the_smallest_bic(
    softening: Begun, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = ["creep", "nonlinear_stiffness", "sensor_lag"]
    monkeypatch.setattr(grey_box, "candidate_names", lambda: tried)
    answer, stage, rmse = grey_box.select(softening)
    assert (answer, stage) == ("nonlinear_stiffness", "mechanics")
    assert rmse == pytest.approx(NOISE, rel=0.05)
    assert softening.refit.rmse > 2.0 * NOISE
    answer, _, worse = grey_box.select(softening, ["nonlinear_stiffness"])
    assert answer != "nonlinear_stiffness"
    assert worse > 1.2 * rmse


@pytest.mark.parametrize("planted", ["backlash", "sensor_lag"])
def test_what_converges_slowly_is_fitted_to_its_end(
    planted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = ["backlash", "creep", "friction", "sensor_lag"]
    monkeypatch.setattr(grey_box, "candidate_names", lambda: tried)
    begun = begun_with(nominal_model().with_link(planted))
    answer, _, rmse = grey_box.select(begun)
    assert begun.refit.rmse > 3.0 * NOISE
    assert answer == planted
    assert rmse == pytest.approx(NOISE, rel=0.05)


def test_thresholded_least_squares_finds_the_sparse_weights() -> None:
    rng = np.random.default_rng(5)
    matrix = rng.standard_normal((500, 12)) * np.geomspace(1e-3, 1e3, 12)
    true = np.zeros(12)
    true[[2, 9]] = 3.0, -0.2
    target = matrix @ true + 1e-4 * rng.standard_normal(500)
    found = stlsq(matrix, target, threshold=1e-4)
    assert set(np.flatnonzero(found)) == {2, 9}
    assert found == pytest.approx(true, rel=1e-2)


def test_thresholded_least_squares_may_find_nothing() -> None:
    rng = np.random.default_rng(6)
    assert not stlsq(rng.standard_normal((5000, 3)), rng.standard_normal(5000)).any()
    assert not stlsq(np.zeros((10, 2)), np.ones(10)).any()


def test_every_term_stands_for_an_effect_of_the_library() -> None:
    assert set(TERMS) <= set(registry())


def test_a_hum_is_found_by_sparse_regression() -> None:
    begun = begun_with(nominal_model())
    hummed = [
        Recording(r.name, PERIOD, r.voltage, r.measured + 40e-9 * np.sin(100.0 * np.pi * r.time))
        for r in (*begun.evidence.fitted, *begun.evidence.judged)
    ]
    humming = Evidence.gather(hummed[:1], hummed[1:], Conditions(), begun.nominal.model)
    same = Begun(humming, begun.nominal, begun.refit)
    answer, stage, rmse = regress(same)
    assert (answer, stage) == ("mains_hum", "sensor")
    assert rmse == pytest.approx(NOISE, rel=0.05)
    assert regress(same, ["mains_hum"])[0] != "mains_hum"


@dataclass(frozen=True)
class Left:
    """What a refit left, as if it had been measured."""

    rests: list[Rest]

    def training(self) -> list[Rest]:
        return self.rests

    judging = training


def left_by_a_square(middle: float, seed: int) -> Rest:
    """Residuals of x^2 with a zero of their own, x about the middle, as x is scaled over 0 to 2."""
    rng = np.random.default_rng(seed)
    x = middle + 0.2 * rng.uniform(-1.0, 1.0, 3000)
    left = 50e-9 * (x - 1.0) ** 2
    run = Recording(f"run {seed}", PERIOD, 75.0 * rng.uniform(0.0, 2.0, len(x)), x)
    return Rest(run, x, left - left.mean(), np.ones(len(x), dtype=bool))


def test_recordings_elsewhere_on_the_stroke_have_zeros_of_their_own() -> None:
    left = Left([left_by_a_square(middle, seed) for seed, middle in enumerate((0.2, 1.0, 1.8))])
    answer, _, rmse = regress(cast(Begun, left))
    assert answer == "nonlinear_stiffness"
    assert rmse < 0.1e-9


def test_a_black_box_shrinks_what_follows_from_the_voltage(softening: Begun) -> None:
    left = shrink(softening)
    assert NOISE * 0.9 < left < 0.8 * softening.refit.rmse


def test_a_black_box_adds_nothing_to_noise() -> None:
    begun = begun_with(nominal_model())
    assert shrink(begun) == pytest.approx(begun.refit.rmse, rel=0.01)


def test_a_case_that_cannot_be_read_is_a_failure_of_all(tmp_path: Path) -> None:
    job = {"model": "model.yaml", "recordings": ["a.csv"], "heldout": ["b.csv"], "hold": "zero"}
    (tmp_path / "job.json").write_text(json.dumps(job))
    found = compare(tmp_path)
    assert tuple(found) == METHODS
    assert all(one.rmse is None and "model.yaml" in one.why for one in found.values())
