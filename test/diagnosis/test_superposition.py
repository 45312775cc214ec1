"""Two effects add up: what each takes away alone tells which two belong together."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from driven_by_steps import refitted

from microgripper_control.diagnosis.fits.fitting import base_of, begun
from microgripper_control.diagnosis.fits.trial import with_guess
from microgripper_control.diagnosis.search import superposition
from microgripper_control.diagnosis.search.finishing import POLISHED, refined
from microgripper_control.diagnosis.search.pool import Pool, strongest
from microgripper_control.diagnosis.search.superposition import add_superposed, alike, superposed
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, nominal_model

NOISE = 10e-9  # m
TRUE = {"creep": {"strength": 0.03}, "extra_resonance": {"share": 0.1, "frequency": 90.0}}
ALONE = ("amplifier_lag", "backlash", *TRUE)


def tried_alone(rig: Model) -> Pool:
    """What some effects explain, one at a time, of a rig that is driven by steps."""
    pool = refitted(rig, NOISE)
    base = base_of(pool.evidence, pool.refit)
    for name in ALONE:
        values = TRUE.get(name) or registry()[name].starts(pool.evidence.scales)[0]
        start = begun(base, with_guess(pool.refit.model, name, values), [name])
        pool.add(refined(pool.evidence, start, POLISHED, 9))
    return pool


def test_what_two_leave_is_a_least_squares_fit_of_what_each_takes_away() -> None:
    rng = np.random.default_rng(3)
    a, b, noise = np.linalg.qr(rng.standard_normal((500, 3)))[0].T
    base: Any = SimpleNamespace(rest=2.0 * a + 0.5 * b + 0.1 * noise)
    taken = {"one": 7.0 * a, "other": 0.1 * b, "reversed": -b, "nothing": 0.0 * a}
    scale = np.sqrt(500.0)
    assert superposition._left(base, taken, ("one", "other")) == pytest.approx(0.1 / scale)
    # None may work the other way round than it does alone.
    alone = np.hypot(0.5, 0.1) / scale
    assert superposition._left(base, taken, ("one", "reversed")) == pytest.approx(alone)
    assert superposition._left(base, taken, ("one", "nothing")) == np.inf


def test_the_two_at_work_promise_most_and_are_tried() -> None:
    rig = nominal_model()
    for name, values in TRUE.items():
        rig = rig.with_link(name, **values)
    pool = tried_alone(rig)
    left = superposed(ALONE, pool)
    assert len(left) == 6
    assert next(iter(left)) == frozenset(TRUE)
    assert list(left.values()) == sorted(left.values())
    assert pool.leader.rmse > 5.0 * NOISE
    add_superposed(ALONE, pool, jobs=1)
    assert pool.leader is pool.tried[frozenset(TRUE)]
    assert pool.leader.rmse < 1.5 * NOISE


def test_pairs_that_may_not_join_take_no_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """However much they promise: of six places none was left for what may be tried."""
    pool = tried_alone(nominal_model().with_link("creep", **TRUE["creep"]))
    forbidden = {"creep", "extra_resonance"}
    monkeypatch.setattr(
        superposition, "may_join", lambda _, trial, name: not {*trial.effects, name} <= forbidden
    )
    assert frozenset(forbidden) not in superposed(ALONE, pool)
    assert len(superposed(ALONE, pool)) == 5


def test_a_pair_that_went_astray_is_tried_from_the_other_side() -> None:
    """What explains more alone has bent its own parameters to the other's part of the gap."""
    rig = nominal_model()
    for name, values in TRUE.items():
        rig = rig.with_link(name, **values)
    pool = tried_alone(rig)
    stronger, weaker = (pool.tried[frozenset([name])] for name in strongest(TRUE, pool))
    first, second = stronger.effects[0], weaker.effects[0]
    both = replace(stronger, model=stronger.model.with_link(second, **weaker.model.values(second)))
    pool.tried[frozenset(TRUE)] = replace(both, fitted_rmse=1.1 * stronger.fitted_rmse)
    assert pool.may_gain(stronger, second)
    assert pool.may_gain(weaker, first)
    pool.joined.add((frozenset([first]), second))
    assert not pool.may_gain(stronger, second)
    add_superposed(ALONE, pool, jobs=1)
    assert (frozenset([second]), first) in pool.joined
    assert pool.tried[frozenset(TRUE)].rmse < 1.5 * NOISE


def test_a_pair_that_leaves_less_than_either_is_not_tried_again() -> None:
    pool = tried_alone(nominal_model().with_link("creep", **TRUE["creep"]))
    creep = pool.tried[frozenset(["creep"])]
    model = creep.model.with_link("extra_resonance")
    pair = replace(creep, model=model, fitted_rmse=0.9 * creep.fitted_rmse)
    assert pool.may_gain(creep, "extra_resonance")
    pool.tried[frozenset(TRUE)] = pair
    assert not pool.may_gain(creep, "extra_resonance")
    assert not pool.may_gain(pool.tried[frozenset(["extra_resonance"])], "creep")
    assert not pool.may_gain(creep, "creep")
    assert pool.may_gain(pair, "backlash")


def test_where_one_effect_leaves_noise_no_two_are_tried() -> None:
    pool = tried_alone(nominal_model().with_link("creep", **TRUE["creep"]))
    add_superposed(ALONE, pool, jobs=1)
    assert {len(effects) for effects in pool.tried} == {1}


def test_what_may_be_meant_in_the_place_of_another_takes_away_the_same() -> None:
    """A sensor that lags takes the place of an amplifier; creep does not, however much it takes."""
    pool = tried_alone(nominal_model().with_link("amplifier_lag", lag=2e-3))
    base = base_of(pool.evidence, pool.refit)
    lagging = with_guess(pool.refit.model, "sensor_lag", {"time_constant": 2e-3})
    pool.add(refined(pool.evidence, begun(base, lagging, ["sensor_lag"]), POLISHED, 9))
    assert alike("amplifier_lag", ["backlash", "sensor_lag", "creep"], pool)[0] == "sensor_lag"
    assert alike("creep", ["amplifier_lag"], pool) == []
