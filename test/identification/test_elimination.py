"""The eliminated initial h against the whole Jacobian."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.identification.confidence import spread_of
from microgripper_control.identification.determined import spread
from microgripper_control.identification.elimination import (
    Split,
    turned_jacobian,
    turned_residuals,
)
from microgripper_control.identification.nuisance import Conditions, response
from microgripper_control.identification.problem import Problem
from microgripper_control.identification.start import GRID_KEYS, better_start
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

LENGTHS = (300, 500, 400)


def problem_of(initial: Initial) -> tuple[Problem, Array]:
    """Three recordings, with some samples masked, and a point that does not fit them."""
    model = nominal_model()
    random = np.random.default_rng(21)
    recordings, used = [], []
    for number, length in enumerate(LENGTHS):
        time = np.arange(length) / length
        voltage = 75.0 * (1.0 - np.cos(2.0 * np.pi * (1.0 + 0.3 * number) * time + number))
        noise = 15e-9 * random.standard_normal(length)
        measured = simulate(model, voltage, 1e-3, initial_hysteresis=2e-7 * number) + noise
        recordings.append(Recording(f"run {number}", 1e-3, voltage, measured))
        used.append(random.random(length) < 0.9)
    off = model.with_values({key: 1.05 * model.value(*key) for key in GRID_KEYS})
    problem = Problem(off, recordings, Conditions(initial=initial), GRID_KEYS, used)
    return problem, problem.point(off, [1e-7, -1e-7, 3e-7])


@pytest.mark.parametrize("initial", [Initial.FIRST_SAMPLE, Initial.REST])
def test_the_turned_problem_has_the_products_of_the_whole_one(initial: Initial) -> None:
    problem, z = problem_of(initial)
    residuals, jacobian = problem.residuals(z), problem.jacobian(z)
    turned, slopes = turned_residuals(problem, z), turned_jacobian(problem, z)
    assert len(z) == (7 if initial is Initial.FIRST_SAMPLE else 4)
    assert slopes.shape == (len(z) + 1, len(z))
    assert turned @ turned == pytest.approx(residuals @ residuals, rel=1e-12)
    sizes = np.linalg.norm(jacobian, axis=0)
    np.testing.assert_allclose(
        slopes.T @ turned / sizes, jacobian.T @ residuals / sizes, atol=1e-10 * turned[0]
    )
    np.testing.assert_allclose(
        slopes.T @ slopes / np.outer(sizes, sizes),
        jacobian.T @ jacobian / np.outer(sizes, sizes),
        atol=1e-10,
    )


def test_a_jacobian_simulates_each_recording_once_a_column(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem, z = problem_of(Initial.FIRST_SAMPLE)
    problem.residuals(z)
    asked = []

    def counted(*arguments: object) -> Array:
        asked.append(arguments)
        return response(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr("microgripper_control.identification.problem.response", counted)
    problem.jacobian(z)
    assert len(asked) == len(GRID_KEYS) * len(LENGTHS) + len(LENGTHS)


def test_weights_of_courses_that_are_nearly_one_are_no_rounding() -> None:
    """Creep that is slower than a recording is a drift, and a zero: which, it does not show."""
    model = (
        nominal_model().with_link("thermal_drift").with_link("creep", fastest=30.0, slowest=300.0)
    )
    problem, z = problem_of(Initial.REST)
    problem = Problem(model, problem.recordings, problem.conditions, (), problem.used)
    for nuisance in problem.nuisances(z[:0]):
        assert np.max(np.abs(nuisance.weights)) < 1e-4


def test_variances_are_those_of_the_whole_jacobian() -> None:
    problem, z = problem_of(Initial.FIRST_SAMPLE)
    whole = spread_of(problem.jacobian(z), problem.split_residuals(z), problem.eliminated)
    found = spread(problem, z)
    np.testing.assert_allclose(found.variances, whole.variances[:4], rtol=1e-6)
    np.testing.assert_allclose(found.freedom, whole.freedom[:4], rtol=1e-6)


def test_a_split_adds_up_to_the_columns() -> None:
    random = np.random.default_rng(22)
    own, columns = random.standard_normal(40), random.standard_normal((40, 3))
    split = Split.of(own, columns)
    np.testing.assert_allclose(own @ split.rest, 0.0, atol=1e-12)
    np.testing.assert_allclose(split.rest + np.outer(own / split.sizes, split.along), columns)


def test_an_initial_state_that_shows_nowhere_takes_nothing_away() -> None:
    columns = np.random.default_rng(23).standard_normal((40, 3))
    split = Split.of(np.zeros(40), columns)
    assert split.sizes[0] == 0.0
    np.testing.assert_array_equal(split.rest, columns)


def test_the_start_gives_each_recording_an_initial_state_of_its_own() -> None:
    problem, _ = problem_of(Initial.FIRST_SAMPLE)
    model, initial = better_start(problem, [0.0, 0.0, 0.0])
    found = problem.residuals(problem.point(model, initial))
    for number in range(len(LENGTHS)):
        without = [0.0 if index == number else h for index, h in enumerate(initial)]
        left = problem.residuals(problem.point(model, without))
        assert left @ left > 1.1 * (found @ found)
