"""What a force that remembers the way is called: friction holds briefly, hysteresis bends long."""

from __future__ import annotations

import math

import pytest

from microgripper_control.effects.base import Scales, Values
from microgripper_control.effects.mechanics.friction import presliding
from microgripper_control.effects.mechanics.restoring_force_hysteresis import memory
from microgripper_control.effects.registry import link_named

STROKE = 100e-6  # m
SCALES = Scales(1e-3, 10.0, (0.0, 100.0), 100.0, (0.0, STROKE), 5e7, 0.0038)


def friction(way: float) -> Values:
    """Friction that holds for a way, m."""
    stiffness = 1e7
    springs = {"distributed": 0.0, "decades": 0.5, "taper": 0.0}
    return {"coulomb": stiffness * way, "stiffness": stiffness, "excess": 0.0, **springs}


def bouc_wen(way: float) -> Values:
    """Hysteresis of a force that is forgotten after a way, m."""
    rates = {"beta": 0.75 / way, "gamma": 0.25 / way}
    return {"alpha": 1e6, **rates, "n": 1.0, "distributed": 0.0, "widest": 1.0}


def slipping(way: float) -> Values:
    """Springs of which the last has turned its slip after a way, m."""
    return bouc_wen(way) | {"distributed": 1.0, "widest": way / 2.0}


@pytest.mark.parametrize("way", [0.2e-6, 30e-6])
def test_the_way_is_read_off_the_parameters(way: float) -> None:
    assert presliding(friction(way)) == pytest.approx(way)
    assert memory(bouc_wen(way)) == pytest.approx(way)
    assert memory(slipping(way)) == pytest.approx(way)


def test_what_never_bends_is_never_forgotten() -> None:
    assert memory(bouc_wen(1e-6) | {"beta": 0.0, "gamma": 0.0}) == math.inf


@pytest.mark.parametrize(
    ("way", "as_friction", "as_hysteresis"),
    [(1e-6, 0.0, 1.0), (4e-6, 0.0, 1.0), (8e-6, 0.0, 0.0), (16e-6, 1.0, 0.0), (50e-6, 1.0, 0.0)],
)
def test_either_law_is_unusual_at_the_others_size(
    way: float, as_friction: float, as_hysteresis: float
) -> None:
    hysteresis = link_named("restoring_force_hysteresis")
    assert link_named("friction").unusual(friction(way), SCALES) == pytest.approx(as_friction)
    for values in (bouc_wen(way), slipping(way)):
        assert hysteresis.unusual(values, SCALES) == pytest.approx(as_hysteresis, abs=1e-9)


@pytest.mark.parametrize(("elastic", "unusual"), [(1.4, 0.0), (8.0, 0.0), (16.0, 1.0), (1e9, 1.0)])
def test_a_force_that_gives_all_back_is_unusual_for_a_hysteresis(
    elastic: float, unusual: float
) -> None:
    """The public benchmark has gamma = -1.4 beta."""
    values = bouc_wen(16e-6) | {"beta": 4e4 / elastic, "gamma": -4e4}
    found = link_named("restoring_force_hysteresis").unusual(values, SCALES)
    assert found == pytest.approx(unusual, abs=1e-9)
