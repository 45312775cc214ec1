"""How much of a gap anything deterministic could close: all of a law's, none of the noise's."""

from __future__ import annotations

import numpy as np
import pytest
from planted_residuals import NOISE, PERIOD, loops, multisine, planted, staircase
from scipy.signal import lfilter

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual
from microgripper_control.diagnosis.signs import freeform
from microgripper_control.diagnosis.signs.freeform import explainable
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate


def course(count: int = 20000) -> Array:
    """Loops, a staircase and a multisine, one after the other."""
    part = count // 3
    return np.concatenate([loops(part), staircase(part), multisine(count - 2 * part)])


def left_by(
    effect: str, voltage: Array, seed: int = 0, odd: bool = False, **values: float
) -> Residual:
    """What the paper's plant without an effect leaves of one with it."""
    model = nominal_model()
    plain = simulate(model, voltage, PERIOD)
    left = simulate(model.with_link(effect, **values), voltage, PERIOD) - plain
    return planted(voltage, left, seed, odd, plain)


@pytest.mark.parametrize("seed", range(5))
def test_white_noise_is_not_explained(seed: int) -> None:
    voltage = course()
    fitted, judged = planted(voltage, 0.0, seed, odd=True), planted(voltage, 0.0, seed + 100)
    assert explainable([fitted], [judged], NOISE) == 0.0


def test_coloured_noise_is_not_explained() -> None:
    voltage = multisine()
    rough = [
        60e-9 * lfilter([0.3], [1.0, -0.7], np.random.default_rng(s).standard_normal(len(voltage)))
        for s in (1, 2)
    ]
    fitted, judged = planted(voltage, rough[0], 1, odd=True), planted(voltage, rough[1], 2)
    assert explainable([fitted], [judged], NOISE) < 0.1


@pytest.mark.parametrize(
    ("effect", "values", "least"),
    [
        ("creep", {"strength": 0.02}, 0.8),
        ("transport_delay", {"delay": 2e-3}, 0.8),
        ("amplifier_lag", {"lag": 2e-3}, 0.8),
        ("saturation", {"high": 120.0}, 0.8),
        ("rate_dependent_hysteresis", {"strength": 0.1}, 0.5),
    ],
)
def test_what_a_law_leaves_is_explained(
    effect: str, values: dict[str, float], least: float
) -> None:
    first, second = course(), course()[::-1].copy()
    fitted = left_by(effect, first, 1, odd=True, **values)
    judged = left_by(effect, second, 2, **values)
    assert explainable([fitted], [judged], NOISE) > least


def test_play_is_explained_where_the_plant_does_not_ring() -> None:
    # A step makes the plant overshoot between two samples, which carries the finger along.
    fitted = left_by("backlash", loops(), 1, odd=True, play=4e-7)
    judged = left_by("backlash", loops(20000, 1.3), 2, play=4e-7)
    assert explainable([fitted], [judged], NOISE) > 0.8


def test_blocks_of_one_recording_serve_for_both() -> None:
    voltage = course()
    fitted = left_by("creep", voltage, 1, odd=True, strength=0.02)
    judged = left_by("creep", voltage, 1, strength=0.02)
    assert explainable([fitted], [judged], NOISE) > 0.8


def test_of_long_recordings_it_looks_at_few_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at = []

    class Counted(freeform._Moments):
        @classmethod
        def of(cls, matrix: Array, target: Array, fold: Array) -> freeform._Moments:
            looked_at.append(len(matrix))
            return super().of(matrix, target, fold)

    monkeypatch.setattr(freeform, "_Moments", Counted)
    voltage = course(60_000)
    fitted = left_by("creep", voltage, 1, odd=True, strength=0.02)
    judged = left_by("creep", voltage, 2, strength=0.02)
    assert np.count_nonzero(fitted.counted) > 2 * freeform.MOST_ROWS
    assert explainable([fitted], [judged], NOISE) > 0.8
    assert len(looked_at) == 1
    assert 0.5 * freeform.MOST_ROWS < looked_at[0] <= freeform.MOST_ROWS
