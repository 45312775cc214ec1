"""Explanations are tried beside what the nominal model has, on settled evidence as well."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.diagnose import candidate_names, diagnose
from microgripper_control.diagnosis.fits.trial import Trial, fitted_keys, judged, unfitted
from microgripper_control.diagnosis.search import exploration, resettling, rounds
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

EVIDENCE: Any = SimpleNamespace(nominal=nominal_model())


def test_on_settled_evidence_no_effect_is_tried_beside_itself(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What the nominal model has already is no candidate, and does not begin afresh."""
    tried: list[tuple[str, tuple[str, ...]]] = []
    original = rounds.attempt

    def attempt(*given: Any) -> tuple[str, Trial | None, str]:  # noqa: ANN401
        _, bases, name, *_ = given
        tried.append((name, bases[0].trial.effects))
        return original(*given)

    for module in (rounds, resettling):
        monkeypatch.setattr(module, "attempt", attempt)
    known = nominal_model().with_link("amplifier_lag", lag=2e-3)
    rig = known.with_link("creep").with_link("backlash")
    voltage = 80.0 - 75.0 * np.cos(2.0 * np.pi * np.arange(3000) / 1000.0)
    noise = 15e-9 * np.random.default_rng(4).standard_normal(3000)
    recording = Recording("run", 1e-3, voltage, simulate(rig, voltage, 1e-3) + noise)
    others = [name for name in candidate_names() if name not in ("creep", "transport_delay")]
    diagnose(known, [recording], jobs=1, without=others)
    assert ("creep", ("amplifier_lag",)) in tried
    assert len(tried) > 2  # afresh, too
    assert all(name not in effects for name, effects in tried)


def exchanged(
    monkeypatch: pytest.MonkeyPatch,
    closed: Mapping[tuple[str, ...], float],
    *,
    rest: bool = False,
    costly: Collection[str] = (),
) -> list[tuple[str, str]]:
    """What is tried beside which effect of a pair, of a gap that was closed so far.

    `rest`: the pair leaves more than noise. A rail takes away nearly what a contact does.
    """
    played: list[tuple[str, str]] = []

    def play(evidence: object, bases: Any, names: list[str], *given: object) -> None:  # noqa: ANN401
        played.extend((bases[0].effects[0], name) for name in names)

    monkeypatch.setattr(exploration, "is_costly", lambda evidence, model: model[0] in costly)
    monkeypatch.setattr(exploration, "may_join", lambda evidence, trial, effect: True)
    monkeypatch.setattr(exploration, "base_of", lambda evidence, trial: trial)
    monkeypatch.setattr(exploration, "play", play)
    near = {"contact", "saturation"}
    monkeypatch.setattr(
        exploration, "alike", lambda name, others, pool: [o for o in others if {name, o} <= near]
    )
    tried = {frozenset(e): SimpleNamespace(effects=e, model=e) for e in closed}
    pool: Any = SimpleNamespace(
        evidence=EVIDENCE,
        tried=tried,
        may_gain=lambda kept, name: frozenset(kept.effects) | {name} not in tried,
        closed=lambda trial: closed[trial.effects],
        leaves_a_rest=lambda trial: rest,
        best=lambda size, count: sorted(
            (t for e, t in tried.items() if len(e) == size), key=lambda t: -closed[t.effects]
        )[:count],
    )
    names = [effects[0] for effects in closed if len(effects) == 1]
    exploration._exchange(names, pool, lambda *done: None, 1)
    return played


def test_in_the_place_of_one_of_two_is_tried_what_explains_the_same_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a rail and creep, contact may come nearest at first, and finds creep: not the rail."""
    closed = {
        ("contact",): 0.50,
        ("saturation",): 0.48,
        ("nonlinear_stiffness",): 0.40,
        ("creep",): 0.45,
        ("contact", "creep"): 0.90,
    }
    assert exchanged(monkeypatch, closed) == [("creep", "saturation")]
    # Where the two leave a rest, all others may be meant, but beside a costly one few.
    beside_creep = [("creep", "saturation"), ("creep", "nonlinear_stiffness")]
    found = exchanged(monkeypatch, closed, rest=True, costly=["contact"])
    assert found == beside_creep
    found = exchanged(monkeypatch, closed, rest=True, costly=["contact", "nonlinear_stiffness"])
    assert found == beside_creep
    # A costly one takes a costly one's place, and no other.
    found = exchanged(monkeypatch, closed, rest=True, costly=["nonlinear_stiffness"])
    assert found == [("creep", "saturation"), ("contact", "saturation")]


@pytest.mark.parametrize(
    ("pair", "rest", "worth"), [(0.60, True, False), (0.68, True, True), (0.68, False, False)]
)
def test_a_pair_that_adds_little_is_taken_apart_if_it_leaves_a_rest_yet_much_less(
    monkeypatch: pytest.MonkeyPatch, pair: float, rest: bool, worth: bool
) -> None:
    closed = {("contact",): 0.50, ("saturation",): 0.48, ("creep",): 0.45}
    found = exchanged(monkeypatch, closed | {("contact", "creep"): pair}, rest=rest)
    assert bool(found) == worth


def test_a_costly_force_may_take_the_place_of_a_play(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside a limit of the slope a play did for friction, which does nothing by itself."""
    closed = {
        ("backlash",): 0.55,
        ("slew_limit",): 0.22,
        ("friction",): 0.01,
        ("backlash", "slew_limit"): 0.77,
    }
    found = exchanged(monkeypatch, closed, rest=True, costly=["friction"])
    assert found == [("slew_limit", "friction")]


def test_what_would_leave_nearly_all_is_not_fitted_unless_it_is_strong_or_shows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    left = {"creep": 0.3, "contact": 0.97, "friction": 0.99, "mains_hum": 1.0, "backlash": np.inf}

    def promise(evidence: object, bases: object, name: str, alone: object) -> tuple[str, float]:
        return name, left[name]

    monkeypatch.setattr(rounds, "promise", promise)
    strongest = SimpleNamespace(effects=("friction",))
    pool: Any = SimpleNamespace(evidence=EVIDENCE, tried={}, best=lambda size, count: [strongest])
    nothing: Any = None
    ways = rounds._promising(nothing, nothing, list(left), ["mains_hum"], pool, 1)
    assert ways == ["creep", "friction", "mains_hum"]


@pytest.mark.parametrize("arrived", [False, True])
def test_which_are_fitted_depends_on_no_order_of_arrival(
    monkeypatch: pytest.MonkeyPatch, arrived: bool
) -> None:
    """What promises nothing leaves the same to the last digit, and workers end as they please."""
    lags = ["amplifier_lag", "sensor_lag", "transport_delay"]
    looks = [(name, 1.0) for name in lags]
    monkeypatch.setattr(
        rounds, "side_by_side", lambda *_: reversed(looks) if arrived else iter(looks)
    )
    pool: Any = SimpleNamespace(evidence=EVIDENCE, tried={}, best=lambda size, count: [])
    nothing: Any = None
    ways = rounds._promising(nothing, nothing, lags, set(lags), pool, 1)
    assert ways == lags[:2]


def test_what_promises_most_is_fitted_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of few places none is left for it where the strong ones and those that show come first."""
    left = {"creep": 0.9, "contact": 0.8, "nonlinear_stiffness": 0.7, "backlash": 0.75}
    monkeypatch.setattr(rounds, "promise", lambda *given: (given[2], left[given[2]]))
    strongest = [SimpleNamespace(effects=(name,)) for name in ("creep", "contact")]
    pool: Any = SimpleNamespace(evidence=EVIDENCE, tried={}, best=lambda size, count: strongest)
    nothing: Any = None
    ways = rounds._promising(nothing, nothing, list(left), (), pool, 1)
    assert ways == ["nonlinear_stiffness", "contact", "creep", "backlash"]


def test_an_effect_that_shows_may_lead_from_further_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    """A play and a warm-up: creep from before the recordings comes nearest to both of them."""
    monkeypatch.setattr(exploration, "is_costly", lambda evidence, model: False)
    creep, drift = (
        SimpleNamespace(effects=(name,), model=None) for name in ("creep", "thermal_drift")
    )
    closed = {"creep": 0.50, "thermal_drift": 0.34}
    pool: Any = SimpleNamespace(
        evidence=EVIDENCE,
        closed=lambda trial: closed[trial.effects[0]],
        best=lambda size, count: [creep] if size == 1 else [],
        leaves_more=lambda trial: True,
    )
    leader: Any = drift
    assert not exploration._may_lead(leader, pool, 1, set())
    assert exploration._may_lead(leader, pool, 1, {"thermal_drift"})


@pytest.mark.parametrize(
    ("long", "closed", "tried"),
    [
        (False, 0.7, ["creep", "contact", "backlash"]),
        (True, 0.7, ["backlash", "contact"]),
        (True, 0.55, ["creep", "contact", "backlash"]),
    ],
)
def test_beside_a_force_that_takes_long_few_are_tried_unless_it_leaves_much(
    monkeypatch: pytest.MonkeyPatch, long: bool, closed: float, tried: list[str]
) -> None:
    """They are the strongest by themselves."""
    played: list[str] = []
    monkeypatch.setattr(exploration, "is_costly", lambda evidence, model: True)
    monkeypatch.setattr(exploration, "is_long", lambda evidence, model: long)
    monkeypatch.setattr(exploration, "may_join", lambda evidence, leader, name: True)
    monkeypatch.setattr(exploration, "base_of", lambda evidence, trial: trial)
    monkeypatch.setattr(exploration, "_shown_by", lambda leader, pool: [])
    monkeypatch.setattr(exploration, "refined", lambda evidence, trial, *limits: trial)
    monkeypatch.setattr(
        exploration, "play", lambda evidence, bases, names, *_: played.extend(names)
    )
    friction, *others = (
        SimpleNamespace(effects=(name,), model=None)
        for name in ("friction", "backlash", "contact", "creep")
    )
    pool: Any = SimpleNamespace(
        evidence=EVIDENCE,
        tried={frozenset(trial.effects): trial for trial in (friction, *others)},
        may_gain=lambda kept, name: name not in kept.effects,
        closed=lambda trial: closed,
        best=lambda size, count: [friction, *others],
        add=lambda trial: None,
    )
    leader: Any = friction
    names = ["creep", "contact", "backlash", "friction"]
    exploration._join(leader, names, pool, lambda *done: None, 1)
    assert played == tried


def test_what_joined_on_a_wrong_guess_begins_anew() -> None:
    """A law with other values may have been taken for the object's, beside a hum fitted to both."""
    rig = nominal_model().with_link("contact", position=10e-6, stiffness=4e6)
    voltage = 75.0 - 70.0 * np.cos(2.0 * np.pi * np.arange(6000) / 1000.0)
    time = 1e-3 * np.arange(6000)
    random = np.random.default_rng(6)
    reading = simulate(rig, voltage, 1e-3) + 2e-7 * np.sin(2.0 * np.pi * 50.0 * time)
    recording = Recording("run", 1e-3, voltage, reading + 15e-9 * random.standard_normal(6000))
    evidence = Evidence.gather([recording], [], Conditions(), nominal_model())
    before = nominal_trial(evidence, nominal_model())
    pool = Pool(evidence, before, refit_trial(evidence, before))
    wrong = pool.refit.model.with_link("mains_hum", frequency=50.0)
    wrong = wrong.with_link("contact", position=8e-6, stiffness=1e6, damping=20.0)
    free = (*pool.refit.free, *fitted_keys(wrong, ["contact", "mains_hum"]))
    pool.add(judged(evidence, unfitted(evidence, replace(pool.refit, model=wrong, free=free))))
    assert 30e-9 < pool.closest.rmse < pool.refit.rmse
    exploration._begin_anew(pool, lambda *done: None, 1)
    assert pool.closest.rmse < 16e-9
    assert pool.closest.model.value("contact", "position") == pytest.approx(10e-6, rel=0.02)


@pytest.mark.parametrize(
    ("followed", "unexplained", "led", "beside"),
    [
        (0.5, True, {"creep"}, ["thermal_drift"]),
        (0.5, True, {"creep", "thermal_drift"}, []),
        (0.5, False, set(), []),
        (0.95, True, set(), []),
    ],
)
def test_others_are_tried_beside_a_drift_that_follows_much_of_an_unexplained_gap(
    monkeypatch: pytest.MonkeyPatch,
    followed: float,
    unexplained: bool,
    led: set[str],
    beside: list[str],
) -> None:
    joined: list[str] = []
    monkeypatch.setattr(
        exploration, "_join", lambda leader, *given: joined.append(leader.effects[0])
    )
    names = ["creep", "thermal_drift", "mains_hum"]
    pool: Any = SimpleNamespace(
        tried={
            frozenset([name]): SimpleNamespace(effects=(name,), fitted_rmse=followed)
            for name in names[:2]
        },
        refit=SimpleNamespace(fitted_rmse=1.0),
        leader=None,
        leaves_more=lambda trial: unexplained,
    )
    exploration._join_courses(names, led, pool, lambda *given: None, 1)
    assert joined == beside
