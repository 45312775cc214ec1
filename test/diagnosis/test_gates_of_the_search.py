"""What the search gives up and what it does not: each gate, open and shut."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import base_of
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.search import attempt as attempts
from microgripper_control.diagnosis.search import (
    exploration,
    from_a_part,
    from_guesses,
    resettling,
    rounds,
    stretches,
)
from microgripper_control.diagnosis.search.from_guesses import FALLEN_SHORT
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.diagnosis.search.screening import Guess
from microgripper_control.diagnosis.search.scrutiny import Scrutiny
from microgripper_control.diagnosis.search.stretches import HIDDEN, on_a_part
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3  # s
NOTHING: Any = None
FREE = (("bouc_wen", "d"),)
EVIDENCE: Any = SimpleNamespace(nominal=nominal_model())


def model_with(*effects: str) -> Model:
    model = nominal_model()
    for name in effects:
        model = model.with_link(name)
    return model


def trial(*effects: str, fitted: float = 50e-9, judging: float = 50e-9) -> Trial:
    """A trial of some effects that leaves so much, m, where it is fitted and judged."""
    return Trial(model_with(*effects), (), (), fitted, (np.full(4, judging),))


def pool_of(*trials: Trial, refit: float = 100e-9) -> Pool:
    """A pool with some trials, of a refit that leaves so much, m."""
    base = trial(fitted=refit, judging=refit)
    tried = {frozenset(one.effects): one for one in trials}
    return Pool(EVIDENCE, nominal=base, refit=base, tried=tried)


# Backwards.


def test_the_best_is_tried_without_each_of_its_effects(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what joined first something may be superfluous by now; what is known is fitted briefly."""
    steps: dict[tuple[str, ...], int] = {}

    def refined(evidence: object, one: Trial, tolerance: float, evaluations: int) -> Trial:
        steps[one.effects] = evaluations
        return trial(*one.effects, fitted=29e-9, judging=29e-9)

    monkeypatch.setattr(exploration, "refined", refined)
    monkeypatch.setattr(Pool, "add", lambda pool, one: kept.append(one.effects))
    kept: list[tuple[str, ...]] = []
    best = trial("creep", "backlash", "sensor_lag", fitted=30e-9, judging=30e-9)
    exploration._check_backwards(pool_of(best, trial("creep", "backlash")))
    fewer = [("creep", "backlash"), ("creep", "sensor_lag"), ("backlash", "sensor_lag")]
    assert {frozenset(one) for one in steps} == {frozenset(one) for one in fewer}
    assert {frozenset(one) for one in kept} == {frozenset(one) for one in fewer}
    briefly = {frozenset(one): count for one, count in steps.items()}
    assert briefly.pop(frozenset(fewer[0])) < min(briefly.values())


def test_what_has_one_effect_has_none_to_spare(monkeypatch: pytest.MonkeyPatch) -> None:
    def refined(*given: object) -> Trial:
        raise AssertionError("fitted without its only effect")

    monkeypatch.setattr(exploration, "refined", refined)
    exploration._check_backwards(pool_of(trial("creep")))


# What is read off.


def test_a_grid_goes_behind_the_best_of_each_size(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = "sensor_quantization"
    put: list[tuple[str, ...]] = []

    def behind(evidence: object, leader: Trial, name: str) -> Trial:
        assert name == grid
        put.append(leader.effects)
        return trial(*leader.effects, name, fitted=20e-9, judging=20e-9)

    monkeypatch.setattr(exploration, "behind", behind)
    monkeypatch.setattr(Pool, "drop_idle_grid", lambda pool: None)
    monkeypatch.setattr(Pool, "add", lambda pool, one: None)
    monkeypatch.setattr(exploration, "BEAM", 2)
    ways = [trial("creep", fitted=40e-9, judging=40e-9), trial(grid, fitted=45e-9, judging=45e-9)]
    pair = trial("creep", "backlash", fitted=30e-9, judging=30e-9)
    pool = pool_of(*ways, pair, trial("friction", fitted=90e-9, judging=90e-9))
    exploration._add_chosen(pool, [grid, "creep", "backlash"])
    assert put == [("creep",), ("creep", "backlash")]  # not behind itself, nor behind the third
    untried = pool_of(ways[0], pair)
    put.clear()
    exploration._add_chosen(untried, [grid])
    assert not put


# What leads.


@pytest.mark.parametrize(("costly", "third"), [(False, True), (True, False)])
def test_beside_a_costly_pair_no_third_is_tried(
    costly: bool, third: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exploration, "is_costly", lambda evidence, model: costly)
    monkeypatch.setattr(Pool, "leaves_more", lambda pool, one: True)
    monkeypatch.setattr(Pool, "noise_floor", 0.0)
    alone = trial("friction", fitted=70e-9, judging=70e-9)
    pair = trial("friction", "creep", fitted=30e-9, judging=30e-9)
    assert exploration._worth_joining(pool_of(alone, pair), 2) == third


@pytest.mark.parametrize(
    ("costly", "left", "leads"),
    [(True, 20e-9, False), (True, 30e-9, True), (False, 20e-9, True)],
)
def test_a_costly_force_that_leaves_little_leads_no_other(
    costly: bool, left: float, leads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exploration, "is_costly", lambda evidence, model: costly)
    monkeypatch.setattr(Pool, "leaves_more", lambda pool, one: True)
    monkeypatch.setattr(Pool, "noise_floor", 0.0)
    leader = trial("friction", fitted=left, judging=left)
    assert exploration._may_lead(leader, pool_of(leader), 1, set()) == leads


def test_what_does_harm_where_it_is_judged_is_not_the_closest() -> None:
    """However closely it follows what it was fitted to."""
    bent = trial("friction", fitted=10e-9, judging=110e-9)
    sound = trial("creep", fitted=40e-9, judging=60e-9)
    assert pool_of(bent, sound).closest is sound
    pool = pool_of(bent)
    assert pool.closest is pool.refit


# From where.


@pytest.mark.parametrize(("unexplained", "far"), [(True, True), (False, False)])
def test_the_nominal_model_is_begun_from_while_a_gap_is_unexplained(
    unexplained: bool, far: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A refit may have gone astray; lags begin from the nominal model in any case."""
    begun: dict[str, int] = {}

    def play(evidence: object, bases: Any, names: list[str], *given: object) -> None:  # noqa: ANN401
        begun.update(dict.fromkeys(names, len(bases)))

    monkeypatch.setattr(exploration, "play", play)
    monkeypatch.setattr(exploration, "base_of", lambda evidence, one: one)
    monkeypatch.setattr(exploration, "_is_first", lambda name, evidence, refit: False)
    monkeypatch.setattr(exploration, "is_costly_with", lambda *given: given[-1] == "friction")
    monkeypatch.setattr(exploration, "on_the_sensors_clock", lambda pool, jobs: pool)
    monkeypatch.setattr(exploration, "again_if_settled", lambda pool, jobs: pool)
    for name in ("add_further_parts", "add_likened"):
        monkeypatch.setattr(exploration, name, lambda *given: None)
    monkeypatch.setattr(Pool, "unexplained", unexplained)
    refit = trial()
    names = ["creep", "friction", "sensor_lag"]
    exploration.alone(EVIDENCE, refit, [refit], names, jobs=1)
    assert begun == {"sensor_lag": 2, "creep": 1 + far, "friction": 1 + far}


# What is fitted on.


def test_of_what_takes_long_only_a_few_are_played(monkeypatch: pytest.MonkeyPatch) -> None:
    played: list[str] = []

    def attempt(evidence: object, bases: object, name: str, scrutiny: object) -> tuple[object, ...]:
        played.append(name)
        return name, None, "no first guess explains anything"

    names = ["friction", "backlash", "contact", "creep"]
    monkeypatch.setattr(rounds, "attempt", attempt)
    monkeypatch.setattr(rounds, "_promising", lambda evidence, bases, names, *given: names)
    monkeypatch.setattr(rounds, "is_long_with", lambda evidence, one, name: name != "creep")
    monkeypatch.setattr(rounds, "_scrutiny", lambda *given: None)
    base: Any = SimpleNamespace(trial=trial("sensor_lag"))
    monkeypatch.setattr(Pool, "leaves_more", lambda pool, one: False)
    evidence = loops(nominal_model())
    rounds.play(evidence, [base], names, 3, pool_of(), rounds.silent, 1)
    assert set(played) == {"friction", "creep", "backlash"}


def loops(rig: Model, seconds: float = 6.0) -> Evidence:
    """A recording of a rig with 10 nm of noise, some seconds of decaying loops at 2 Hz."""
    t = PERIOD * np.arange(round(seconds / PERIOD))
    voltage = 70.0 - 60.0 * np.cos(4.0 * np.pi * t) * np.exp(-t / seconds)
    noise = np.random.default_rng(11).normal(0.0, 10e-9, len(t))
    recording = Recording("run", PERIOD, voltage, simulate(rig, voltage, PERIOD) + noise)
    return Evidence.gather([recording], [recording], Conditions(), nominal_model())


@pytest.mark.parametrize(("left", "goes_on"), [(35e-9, True), (58e-9, False)])
def test_a_costly_one_goes_on_only_near_the_best(
    left: float, goes_on: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And where it takes a part of the power that the best takes; a cheap one from farther off."""
    monkeypatch.setattr(rounds, "is_costly", lambda evidence, model: "friction" in model.effects)
    before = trial(fitted=90e-9)
    lefts = {"creep": 30e-9, "friction": left, "contact": 59e-9}
    found = [replace(trial(name, fitted=rmse), free=FREE) for name, rmse in lefts.items()]
    pool = pool_of(*found, refit=90e-9)
    monkeypatch.setattr(Pool, "unexplained", False)
    went = rounds._going_on(EVIDENCE, before, found, True, pool)
    names = [one.effects[0] for one in went]
    assert names == ["creep", "contact", *(["friction"] if goes_on else [])]


def test_a_costly_one_must_take_a_part_of_what_the_best_takes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where the best takes little itself, all are near it, and most have done nothing."""
    monkeypatch.setattr(rounds, "is_costly", lambda evidence, model: True)
    before = trial(fitted=100e-9)
    monkeypatch.setattr(Pool, "unexplained", True)
    lefts = {"friction": 90e-9, "backlash": 99e-9}
    found = [replace(trial(name, fitted=rmse), free=FREE) for name, rmse in lefts.items()]
    went = rounds._going_on(EVIDENCE, before, found, True, pool_of(*found))
    assert [one.effects[0] for one in went] == ["friction"]


@pytest.mark.parametrize(("left", "to_the_end"), [(110e-9, False), (90e-9, True)])
def test_a_start_that_is_far_off_after_a_first_fit_is_left(
    left: float, to_the_end: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    fitted: list[float] = []

    def fit_on(evidence: object, one: Trial, *given: object) -> Trial:
        fitted.append(one.fitted_rmse)
        return one

    guess = Guess(NOTHING, model_with("creep"), left=1.0, least=1.0, strength=1.0, idle=False)
    monkeypatch.setattr(Guess, "promised", 1.0)
    monkeypatch.setattr(from_guesses, "is_costly", lambda evidence, model: False)
    monkeypatch.setattr(from_guesses, "extend", lambda *given: trial("creep", fitted=left))
    monkeypatch.setattr(from_guesses, "fit_on", fit_on)
    assert from_guesses._fit_from(NOTHING, guess, "creep", 100e-9) is not None
    assert bool(fitted) == to_the_end


@pytest.mark.parametrize(("hoped", "limit"), [(60e-9, 80e-9), (30e-9, np.inf)])
def test_what_promises_much_may_overshoot_at_first(
    hoped: float, limit: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    limits: list[float] = []

    def fit_from(part: object, guess: object, name: str, too_far: float) -> None:
        limits.append(too_far)

    monkeypatch.setattr(from_guesses, "_fit_from", fit_from)
    anchor: Any = SimpleNamespace(trial=trial("backlash"), residual=np.full(4, 100e-9))
    guess: Any = SimpleNamespace(hoped=hoped)
    scrutiny = Scrutiny(1000, hopeless=40e-9, known=20e-9)
    assert from_guesses.fits_from(EVIDENCE, [anchor], [guess], "creep", scrutiny) == []
    assert limits == [limit]


@pytest.mark.parametrize("short", [True, False])
def test_a_fit_that_falls_short_of_its_promise_begins_with_the_base_first(
    short: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    promised = 10e-9
    first = promised * FALLEN_SHORT * (1.01 if short else 0.99)
    after = {first: first, 20e-9: 5e-9}
    guess = Guess(NOTHING, model_with("creep"), left=1.0, least=1.0, strength=1.0, idle=False)
    monkeypatch.setattr(Guess, "promised", promised)
    monkeypatch.setattr(from_guesses, "is_costly", lambda evidence, model: False)
    monkeypatch.setattr(from_guesses, "extend", lambda *given: trial("creep", fitted=first))
    monkeypatch.setattr(from_guesses, "half_way", lambda *given: trial("creep", fitted=20e-9))
    monkeypatch.setattr(
        from_guesses, "fit_on", lambda evidence, one, *given: trial(fitted=after[one.fitted_rmse])
    )
    found = from_guesses._fit_from(NOTHING, guess, "creep", np.inf)
    assert found is not None
    assert found.fitted_rmse == (5e-9 if short else first)


@pytest.mark.parametrize("hopeless", [50e-9, np.inf])
def test_only_what_is_fitted_to_the_end_is_asked_whether_it_begins_from_nothing(
    hopeless: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def begun_from_nothing(evidence: object, found: Trial, name: str) -> Trial:
        asked.append(name)
        return found

    monkeypatch.setattr(attempts, "_attempt", lambda *given: (trial("friction"), ""))
    monkeypatch.setattr(attempts, "begun_from_nothing", begun_from_nothing)
    attempts.attempt(NOTHING, [], "friction", Scrutiny(1000, hopeless=hopeless))
    assert asked == ([] if np.isfinite(hopeless) else ["friction"])


@pytest.mark.parametrize(
    ("left", "joins", "known", "anew"),
    [
        (40e-9, False, 30e-9, True),
        (25e-9, False, 30e-9, False),  # all samples leave no more than the part
        (40e-9, True, 30e-9, False),
        (40e-9, False, 10e-9, False),  # lost to another by the part already
    ],
)
def test_what_a_part_has_misled_is_fitted_anew_to_more(
    left: float, joins: bool, known: float, anew: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    further: list[float] = []

    def while_it_falls(evidence: object, one: Trial, steps: int) -> Trial:
        further.append(one.fitted_rmse)
        return trial("friction", fitted=15e-9)

    monkeypatch.setattr(from_a_part, "_on_all", lambda *given: trial("friction", fitted=left))
    monkeypatch.setattr(from_a_part, "fit_on", lambda evidence, one, *given, **more: one)
    monkeypatch.setattr(from_a_part, "moved", lambda evidence, one: one)
    monkeypatch.setattr(from_a_part, "while_it_falls", while_it_falls)
    base: Any = SimpleNamespace(
        trial=trial(*(["creep"] if joins else []), fitted=100e-9), residual=np.full(4, 100e-9)
    )
    evidence: Any = SimpleNamespace(nominal=nominal_model(), pieces=lambda most: evidence)
    found = [trial("friction", fitted=20e-9)]
    scrutiny = Scrutiny(1000, hopeless=90e-9, known=known)
    whole = from_a_part._carried(evidence, base, base, found, "friction", scrutiny)
    assert whole is not None
    assert bool(further) == anew
    assert whole.fitted_rmse == (15e-9 if anew else left)


# On what.


@pytest.mark.parametrize(("shown", "whole"), [(0.9 * HIDDEN, True), (1.2 * HIDDEN, False)])
def test_a_part_that_hides_the_gap_is_no_part_to_look_at(
    shown: float, whole: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    evidence = loops(nominal_model())
    base = base_of(evidence, refit_trial(evidence, nominal_trial(evidence, nominal_model())))
    noise = np.random.default_rng(2).normal(0.0, 10e-9, len(base.residual))
    gap = 50e-9 * np.sin(2.0 * np.pi * np.arange(len(noise)) / 500.0)
    bases = [replace(base, residual=noise + gap)]
    anchor = replace(base, residual=noise + shown * gap)
    monkeypatch.setattr(stretches, "base_of", lambda part, one: anchor)
    monkeypatch.setattr(stretches, "is_laborious_with", lambda *given: True)
    looked_at, _ = on_a_part(evidence, bases, "friction", 1000)
    assert (looked_at is evidence) == whole


@pytest.mark.parametrize("better", ["first", "settled"])
def test_the_evidence_that_foretells_the_judging_samples_better_is_kept(
    better: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first rise may be the only one of its kind."""
    later: Any = SimpleNamespace(nominal=nominal_model())
    before: Any = SimpleNamespace(nominal=nominal_model(), settled=lambda: later)
    left = 20e-9 if better == "settled" else 40e-9
    first = trial("creep", fitted=50e-9, judging=30e-9)
    nominal = trial(fitted=100e-9, judging=100e-9)
    pool = Pool(before, nominal, nominal, {frozenset(["creep"]): first})
    monkeypatch.setattr(resettling, "_as_it_was", lambda evidence, one: one)
    monkeypatch.setattr(resettling, "refine", lambda evidence, one, *given: one)
    monkeypatch.setattr(resettling, "polish", lambda evidence, one: trial("creep", judging=left))
    monkeypatch.setattr(
        Pool, "add", lambda pool, one: pool.tried.update({frozenset(one.effects): one})
    )
    monkeypatch.setattr(Pool, "unexplained", False)
    found = resettling.again_if_settled(pool, 1)
    assert (found.evidence is later) == (better == "settled")
