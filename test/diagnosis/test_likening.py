"""Laws that imitate each other are fitted from where the better one is."""

from __future__ import annotations

import pytest
from driven_by_steps import refitted

from microgripper_control.diagnosis.fits.fitting import base_of, begun
from microgripper_control.diagnosis.fits.trial import with_guess
from microgripper_control.diagnosis.search.finishing import POLISHED, refined
from microgripper_control.diagnosis.search.likening import _in_place_of, add_likened
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.effects.base import Values
from microgripper_control.effects.memory_of_the_way import RELEASED
from microgripper_control.plant.model import Model, nominal_model

FRICTION, HYSTERESIS = "friction", "restoring_force_hysteresis"
NOISE = 15e-9  # m
RIG = nominal_model().with_link(FRICTION, coulomb=30.0, stiffness=2e8, excess=0.3)
BOUC_WEN = {"alpha": 2e8, "beta": 2e8 / 35.0, "gamma": 0.0}


def explained(rig: Model, name: str, guess: Values) -> Pool:
    """What one effect explains of a rig that is driven by steps."""
    pool = refitted(rig, NOISE)
    model = with_guess(pool.refit.model, name, guess)
    start = begun(base_of(pool.evidence, pool.refit), model, [name])
    pool.add(refined(pool.evidence, start, POLISHED, 40))
    return pool


def test_friction_is_fitted_from_a_hysteresis_that_imitates_it() -> None:
    pool = explained(RIG, HYSTERESIS, BOUC_WEN)
    left = pool.leader.both
    assert left > 1.02 * NOISE
    add_likened(pool, [FRICTION, HYSTERESIS, "creep"], jobs=1)
    assert set(pool.tried) == {frozenset([FRICTION]), frozenset([HYSTERESIS])}
    assert pool.leader.effects == (FRICTION,)
    assert pool.leader.both < 0.5 * (NOISE + left)
    assert pool.leader.model.value(FRICTION, "coulomb") == pytest.approx(30.0, rel=0.1)


def test_what_a_recording_begins_without_is_told_as_well() -> None:
    """A rig that rested before a recording has let go of what its joints held."""
    friction = {"coulomb": 30.0, "stiffness": 2e7, "excess": 0.0, RELEASED.name: 1.0}
    rig = nominal_model().with_link(FRICTION, **friction)
    pool = explained(rig, FRICTION, rig.values(FRICTION))
    (start,) = _in_place_of(FRICTION, pool, [FRICTION, HYSTERESIS])
    assert start.model.value(HYSTERESIS, RELEASED.name) == 1.0
    add_likened(pool, [FRICTION, HYSTERESIS], jobs=1)
    assert pool.tried[frozenset([HYSTERESIS])].both < 1.1 * pool.leader.both


def test_what_has_found_it_by_itself_is_not_fitted_again() -> None:
    pool = explained(RIG, FRICTION, {"coulomb": 30.0, "stiffness": 2e8, "excess": 0.3})
    pool.tried[frozenset([HYSTERESIS])] = known = pool.leader
    add_likened(pool, [FRICTION, HYSTERESIS], jobs=1)
    assert pool.tried[frozenset([HYSTERESIS])] is known


@pytest.mark.parametrize("rest", [False, True])
def test_a_costly_force_is_tried_where_play_leaves_a_rest(
    monkeypatch: pytest.MonkeyPatch, rest: bool
) -> None:
    pool = explained(nominal_model().with_link("backlash", play=5e-7), "backlash", {"play": 5e-7})
    monkeypatch.setattr(Pool, "leaves_a_rest", lambda *_: rest)
    add_likened(pool, [FRICTION, "backlash"], jobs=1)
    assert (frozenset([FRICTION]) in pool.tried) == rest
