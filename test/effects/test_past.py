"""What h tells of the time before a run: runs that begin late against the whole run."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.effects.past import shares_of_ways
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD = 1e-3  # s
HIGH = 160.0  # V, of the nominal model, from 0 V on
REMEMBERING = {
    "restoring_force_hysteresis": {"alpha": 2e6, "distributed": 1.0, "widest": 8e-6},
    "friction": {"coulomb": 3.0, "stiffness": 2e6},
    "backlash": {"play": 3e-7, "slowness": 0.0},
    "asymmetric_hysteresis": {"tilt": 2e-9, "skew": 1e-7, "reach": 30.0, "onward": 2e-3},
}


def way(*turns: float) -> Array:
    """V, from turn to turn in steps of 0.1 V, then a wait."""
    parts = [
        np.linspace(a, b, round(10.0 * abs(b - a)), endpoint=False) for a, b in pairwise(turns)
    ]
    return np.concatenate([*parts, np.full(500, turns[-1])])


def hysteresis(model: Model, *turns: float) -> float:
    """h, m, at the end of a way."""
    v = model.values("bouc_wen")
    h = 0.0
    for a, b in pairwise(turns):
        h = advance(h, b - a, v["alpha"] * v["d"], v["beta"], v["gamma"], v["n"])
    return h


EVERYWHERE = (0.0, *[HIGH, 0.0] * 4)
PASTS = {
    "first": (0.0, 60.0),
    "risen": (*EVERYWHERE, 60.0),
    "fallen": (*EVERYWHERE, HIGH, 60.0),
    "at the low end": EVERYWHERE,
    "at the high end": (*EVERYWHERE, HIGH),
}


@pytest.mark.parametrize("effect", REMEMBERING)
@pytest.mark.parametrize("past", PASTS)
def test_a_run_that_begins_late_is_the_end_of_the_whole(effect: str, past: str) -> None:
    model = nominal_model().with_link(effect, **REMEMBERING[effect])
    turns = PASTS[past]
    before, after = way(*turns), way(turns[-1], 110.0, 20.0, 80.0)
    together = np.concatenate([before, after])

    def whole(model: Model) -> Array:
        return simulate(model, together, PERIOD, hold=Hold.FIRST)[len(before) :]

    late = simulate(
        model,
        after,
        PERIOD,
        hold=Hold.FIRST,  # steps would make the mass ring, which shakes friction loose
        initial=Initial.FIRST_SAMPLE,
        initial_hysteresis=hysteresis(model, *turns),
    )
    size = np.std(whole(model) - whole(model.without([effect])))  # of what the effect does
    assert np.max(np.abs(late - whole(model))) < 0.02 * size


@pytest.mark.parametrize("effect", ["restoring_force_hysteresis", "friction"])
@pytest.mark.parametrize("past", PASTS)
def test_a_force_that_holds_nothing_begins_where_there_is_none(effect: str, past: str) -> None:
    turns = PASTS[past]
    bare = nominal_model()
    model = bare.with_link(effect, **REMEMBERING[effect], released=1.0)

    def begun(model: Model) -> Array:
        h = hysteresis(model, *turns)
        rest = np.full(50, turns[-1])
        return simulate(model, rest, PERIOD, initial=Initial.FIRST_SAMPLE, initial_hysteresis=h)

    np.testing.assert_allclose(begun(model), begun(bare), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("besides", ["creep", "saturation", "asymmetric_hysteresis"])
def test_what_else_is_in_the_chain_does_not_turn_the_way(besides: str) -> None:
    """Near the high end, where a link that moves one place alone would put it beyond."""
    settings = {
        "creep": {"strength": 0.05},
        "saturation": {"low": -100.0, "high": 150.0},
        "asymmetric_hysteresis": {"tilt": 1e-9, "bulge": 0.0, "twist": 0.0},
    }
    model = nominal_model().with_link(besides, **settings[besides])
    top = 150.0 if besides == "saturation" else HIGH
    h = hysteresis(nominal_model(), 0.0, *[top, 0.0] * 4, top, top - 20.0)
    at = {"initial": Initial.FIRST_SAMPLE, "initial_hysteresis": h}
    rest = np.full(50, top - 20.0)
    bare = simulate(model, rest, PERIOD, **at)
    moved = simulate(model.with_link("backlash", **REMEMBERING["backlash"]), rest, PERIOD, **at)
    np.testing.assert_allclose(moved - bare, 1.5e-7, rtol=0.02)  # it has come down


def test_in_a_narrow_range_loops_take_longer_to_settle() -> None:
    narrow = replace(nominal_model(), voltage_range=(0.0, 20.0))
    model = narrow.with_link("backlash", **REMEMBERING["backlash"])
    h = hysteresis(model, 0.0, *[20.0, 0.0] * 60, 14.0)
    at = {"initial": Initial.FIRST_SAMPLE, "initial_hysteresis": h}
    rest = np.full(50, 14.0)
    moved = simulate(model, rest, PERIOD, **at) - simulate(narrow, rest, PERIOD, **at)
    np.testing.assert_allclose(moved, -1.5e-7, rtol=0.02)  # it has come up


def test_what_has_let_go_does_not_push_beside_other_forces() -> None:
    """Nor does it take from another force what that one holds."""
    touching = nominal_model().with_link("contact", position=5e-6, stiffness=5e7)
    slipping = touching.with_link(
        "restoring_force_hysteresis", **REMEMBERING["restoring_force_hysteresis"]
    )
    at = {"initial": Initial.FIRST_SAMPLE, "initial_hysteresis": hysteresis(touching, 0.0, 100.0)}
    rest = np.full(50, 100.0)
    for model in (touching, slipping):
        released = model.with_link("friction", **REMEMBERING["friction"], released=1.0)
        both = (simulate(one, rest, PERIOD, **at) for one in (released, model))
        np.testing.assert_allclose(*both, rtol=0.0, atol=1e-12)


def test_h_speaks_for_the_ways_beside_it() -> None:
    ways = {"first": 4e-7, "risen": 1e-7, "fallen": -3e-7}
    assert shares_of_ways(4e-7, **ways) == (0.0, 0.0)
    assert shares_of_ways(1e-7, **ways) == (1.0, 0.0)
    assert shares_of_ways(-3e-7, **ways) == (0.0, 1.0)
    assert shares_of_ways(2e-7, **ways) == pytest.approx((2.0 / 3.0, 0.0))
    assert shares_of_ways(-2e-7, **ways) == pytest.approx((0.25, 0.75))
    assert shares_of_ways(-1e-6, **ways) == (0.0, 1.0)  # beyond all of them: the nearest
    assert shares_of_ways(0.0, 0.0, 0.0, 0.0) == (0.0, 0.0)  # where nothing is remembered


def test_a_law_without_bounds_stands_for_a_first_way() -> None:
    unbounded = {("bouc_wen", "gamma"): -5.0}
    model = nominal_model().with_values(unbounded).with_link("backlash", play=3e-7)
    shown = simulate(model, np.full(5, 1e-3), PERIOD, initial=Initial.FIRST_SAMPLE)
    assert np.all(np.isfinite(shown))
