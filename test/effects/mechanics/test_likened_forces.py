"""What one law is told of another makes it do the same."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Scales, Values
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Projection
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

FRICTION, HYSTERESIS = "friction", "restoring_force_hysteresis"
SCALES = Scales(1e-3, 4.0, (0.0, 150.0), 1e3, (0.0, 2e-5), 5e7, 0.004)
TIME = 1e-3 * np.arange(4000)
VOLTAGE = 75.0 + 40.0 * np.sin(9.0 * TIME) + 30.0 * np.sin(23.0 * TIME)


def with_it(paper: Model, name: str, values: Values) -> Array:
    return simulate(paper.with_link(name, **values), VOLTAGE, 1e-3)


@pytest.mark.parametrize(
    ("name", "other", "values"),
    [
        (FRICTION, HYSTERESIS, {"alpha": 2e8, "beta": 5e6, "gamma": 0.0}),
        (HYSTERESIS, FRICTION, {"coulomb": 30.0, "stiffness": 2e8, "excess": 0.0}),
        (
            FRICTION,
            HYSTERESIS,
            {"alpha": 1e7, "distributed": 1.0, "widest": 4e-6, "decades": 1.2, "taper": 0.3},
        ),
        (
            HYSTERESIS,
            FRICTION,
            {
                "coulomb": 40.0,
                "stiffness": 1e8,
                "distributed": 1.0,
                "decades": 1.2,
                "taper": 0.3,
            },
        ),
    ],
)
def test_forces_that_remember_the_way(paper: Model, name: str, other: str, values: Values) -> None:
    whole = {p.name: p.nominal for p in registry()[other].parameters} | values
    likened = registry()[name].likened(other, whole, SCALES)
    without = simulate(paper, VOLTAGE, 1e-3)
    theirs, ours = with_it(paper, other, whole), with_it(paper, name, likened)
    assert np.std(theirs - without) > 100e-9
    assert np.std(ours - theirs) < 0.01 * np.std(theirs - without)


def test_friction_that_sticks_looks_like_play(paper: Model) -> None:
    play = {p.name: p.nominal for p in registry()["backlash"].parameters} | {
        "play": 1e-6,
        "spread": 0.7,
    }
    likened = registry()[FRICTION].likened("backlash", play, SCALES)
    without = simulate(paper, VOLTAGE, 1e-3)
    theirs, ours = with_it(paper, "backlash", play), with_it(paper, FRICTION, likened)
    # What sticks also makes the rig stiffer: the gain is a refit's to find.
    rest = Projection.off(np.vstack([np.ones(len(TIME)), without / np.ptp(without)]))
    assert np.std(rest(ours - theirs)) < 0.4 * np.std(rest(theirs - without))


def test_others_are_like_no_other() -> None:
    assert registry()["creep"].likened(FRICTION, {"coulomb": 10.0}, SCALES) == {}
    for name in (FRICTION, HYSTERESIS):
        assert registry()[name].likened("creep", {"strength": 0.02}, SCALES) == {}
