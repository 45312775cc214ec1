from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from microgripper_control.diagnosis.data.noise import innovation, quietest, usual_innovation

WHITE = np.random.default_rng(4).normal(0.0, 15e-9, 20000)
WAVE = 1e-6 * np.sin(2e-3 * np.pi * np.arange(20000))


def test_white_noise_is_all_new() -> None:
    assert innovation([WHITE]) == pytest.approx(15e-9, rel=0.02)
    assert usual_innovation(WHITE) == pytest.approx(15e-9, rel=0.03)


def test_what_follows_from_its_past_is_not() -> None:
    assert innovation([WHITE + WAVE]) < 1.2 * 15e-9
    assert usual_innovation(WHITE + WAVE) < 1.2 * 15e-9


def test_what_comes_now_and_then_is_new_but_not_usual() -> None:
    steps = WHITE.copy()
    steps[::100] += np.random.default_rng(5).normal(0.0, 1e-6, 200)
    assert innovation([steps]) > 5.0 * 15e-9
    assert usual_innovation(steps) < 1.3 * 15e-9


def test_noise_that_is_soon_forgotten_is_new_some_samples_later() -> None:
    coloured = lfilter([1.0], [1.0, -0.7], WHITE)
    assert innovation([coloured]) == pytest.approx(15e-9, rel=0.02)
    assert innovation([coloured], ahead=10) == pytest.approx(np.std(coloured), rel=0.02)
    assert innovation([coloured + WAVE], ahead=10) < 2.0 * np.std(coloured)


def test_outliers_that_come_all_the_time_are_noise() -> None:
    laplace = np.random.default_rng(6).laplace(0.0, 15e-9 / np.sqrt(2.0), 20000)
    now_and_then = WHITE * np.where(np.random.default_rng(7).random(20000) < 0.05, 3.0, 1.0)
    assert usual_innovation(laplace) == pytest.approx(15e-9, rel=0.1)
    assert usual_innovation(now_and_then) == pytest.approx(15e-9 * np.sqrt(1.4), rel=0.1)


def test_nothing_has_no_noise() -> None:
    assert innovation([np.zeros(100)]) == 0.0
    assert usual_innovation(np.zeros(100)) == 0.0


def test_the_quietest_stretch_that_is_long_enough() -> None:
    assert quietest([4.0 * WHITE, WHITE, 0.1 * WHITE[:30]]) == usual_innovation(WHITE)
    assert quietest([WHITE[:30]]) == np.inf
