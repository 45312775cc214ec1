"""Stiffness against planted values."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.identification.stiffness import fit_stiffness

TRUE = 8.2e5  # N/m


def data(scatter: float, seed: int, points: int = 20, bend: float = 0.0) -> tuple[Array, Array]:
    force = np.linspace(0.0, 120.0, points)
    share = force / 120.0
    stroke = 120.0 / TRUE
    noise = scatter * np.random.default_rng(seed).standard_normal(points)
    return force, force / TRUE + stroke * (noise + 4.0 * bend * share * (1.0 - share)) + 2e-6


def test_an_exact_line_gives_the_planted_stiffness() -> None:
    found = fit_stiffness(*data(0.0, 0))
    assert found.value == pytest.approx(TRUE, rel=1e-12)
    assert found.interval == pytest.approx((TRUE, TRUE), rel=1e-9)
    assert found.offset == pytest.approx(2e-6, rel=1e-9)


def test_the_interval_covers_the_truth_as_often_as_it_says() -> None:
    hits = 0
    for seed in range(1000):
        low, high = fit_stiffness(*data(0.01, seed)).interval
        hits += low <= TRUE <= high
    assert 0.93 <= hits / 1000 <= 0.97


def test_a_bend_is_seen_when_there_is_one_and_only_then() -> None:
    found = fit_stiffness(*data(0.002, 1, bend=0.02))
    assert found.bend_seen
    assert found.bend == pytest.approx(0.02, abs=0.003)
    seen = sum(fit_stiffness(*data(0.01, seed)).bend_seen for seed in range(400))
    assert 0.02 <= seen / 400 <= 0.09


@pytest.mark.parametrize(
    ("force", "displacement", "says"),
    [
        ([0.0, 1.0], [0.0, 1.0], "at least 3"),
        ([0.0, 1.0, 2.0], [0.0, 1.0], "2 displacements"),
        ([0.0, 1.0, np.nan], [0.0, 1.0, 2.0], "not finite"),
        ([1.0, 1.0, 1.0], [0.0, 1.0, 2.0], "vary it"),
        ([0.0, 1e200, 2e300], [0.0, 1.0, 2.0], r"largest force is 2e\+300 N, outside"),
        ([0.0, -1e-200, 1e-200], [0.0, 1.0, 2.0], "largest force is 1e-200 N, outside"),
        ([0.0, 1.0, 2.0], [0.0, 1e200, 2e200], r"largest displacement is 2e\+200 m, outside"),
        ([0.0, 1.0, 2.0], [0.0, 1e-200, 2e-200], "largest displacement is 2e-200 m, outside"),
        ([0.0, 1.0, 2.0], [0.0, 0.0, 0.0], "does not rise"),
        ([0.0, 1.0, 2.0], [0.0, -1.0, -2.0], "does not rise"),
        ([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, -1.0, 0.5], "does not rise"),
    ],
)
def test_data_that_show_no_stiffness_are_refused(
    force: list[float], displacement: list[float], says: str
) -> None:
    with pytest.raises(MicrogripperError, match=says) as raised:
        fit_stiffness(np.array(force), np.array(displacement), "data.csv")
    assert str(raised.value).startswith("data.csv: ")
