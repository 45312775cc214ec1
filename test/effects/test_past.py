"""What h tells of the time before a run: runs that begin late against the whole run."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.effects.material.bouc_wen import advance
from microgripper_control.effects.past import shares_of_ways
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Hold, Initial, simulate

PERIOD = 1e-3  # s
HIGH = 160.0  # V, of the nominal model, from 0 V on
REMEMBERING = {
    "restoring_force_hysteresis": {"alpha": 2e6, "distributed": 1.0, "widest": 8e-6},
    "friction": {"coulomb": 3.0, "stiffness": 2e6},
    "backlash": {"play": 3e-7, "slowness": 0.0},
    "asymmetric_hysteresis": {"tilt": 2e-9, "skew": 1e-7, "reach": 30.0, "delta": 0.0},
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
    model = bare.with_link(effect, **REMEMBERING[effect], held=0.0)

    def begun(model: Model) -> Array:
        h = hysteresis(model, *turns)
        rest = np.full(50, turns[-1])
        return simulate(model, rest, PERIOD, initial=Initial.FIRST_SAMPLE, initial_hysteresis=h)

    np.testing.assert_allclose(begun(model), begun(bare), rtol=0.0, atol=1e-13)


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
