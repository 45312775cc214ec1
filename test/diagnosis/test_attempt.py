"""Which fits of an effect go on."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits import fitting
from microgripper_control.diagnosis.fits.fitting import Base, base_of, begun, extend
from microgripper_control.diagnosis.fits.trial import Trial, unfitted
from microgripper_control.diagnosis.search import attempt as attempts
from microgripper_control.diagnosis.search import finishing, from_a_part, from_guesses
from microgripper_control.diagnosis.search.attempt import attempt, promise
from microgripper_control.diagnosis.search.from_guesses import best_of_each_kind
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.diagnosis.search.scrutiny import Scrutiny
from microgripper_control.effects.base import Scales
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate

EFFECT = "restoring_force_hysteresis"
NOTHING: Any = None
SCALES = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (-1e-5, 1e-5), 5e7, 0.0038)
PERIOD = 1e-4  # s: the rig rings between its samples, so that forces are costly


def fit(distributed: float, left: float) -> Trial:
    return Trial(nominal_model().with_link(EFFECT, distributed=distributed), (), (), left)


def test_the_best_of_each_kind_goes_on_and_no_other() -> None:
    """A joint that slips bit by bit may begin behind one that saturates, and end before it."""
    found = [fit(1.0, 50e-9), fit(0.0, 40e-9), fit(1.0, 60e-9), fit(0.0, 45e-9)]
    assert {trial.fitted_rmse for trial in best_of_each_kind(found, EFFECT)} == {40e-9, 50e-9}
    assert [trial.fitted_rmse for trial in best_of_each_kind(found[:1], EFFECT)] == [50e-9]


@pytest.mark.parametrize(
    ("behind", "known", "hopeless", "fitted_on"),
    [
        (46e-9, 30e-9, math.inf, [40e-9, 46e-9]),
        (90e-9, 30e-9, math.inf, []),
        (46e-9, 19e-9, math.inf, []),
        (46e-9, 30e-9, 39e-9, []),
    ],
)
def test_of_kinds_that_end_close_to_each_other_each_is_fitted_on(
    behind: float,
    known: float,
    hopeless: float,
    fitted_on: list[float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where there is a race, and where it is neither lost to another effect nor hopeless."""
    monkeypatch.setattr(from_guesses, "is_costly", lambda part, model: False)
    for module in (from_guesses, finishing):
        monkeypatch.setattr(module, "fit_on", lambda part, trial, tolerance, evaluations: trial)
    found = [fit(1.0, behind), fit(0.0, 40e-9), fit(0.0, 45e-9), fit(1.0, 99e-9)]
    nothing: Any = None
    scrutiny = Scrutiny(1000, hopeless=hopeless, known=known)
    longer = from_guesses._gone_on_with(nothing, found, EFFECT, scrutiny)
    assert sorted(trial.fitted_rmse for trial in longer) == fitted_on


def bases_of(rig: Model) -> tuple[Evidence, list[Base]]:
    """A recording of a rig, and what a refit of the paper's model leaves of it."""
    paper = nominal_model()
    t = PERIOD * np.arange(8000)
    voltage = 70.0 - 60.0 * np.cos(2.0 * np.pi * 5.0 * t) * np.exp(-t)
    noise = np.random.default_rng(3).normal(0.0, 10e-9, len(t))
    recording = Recording("run", PERIOD, voltage, simulate(rig, voltage, PERIOD) + noise)
    evidence = Evidence.gather([recording], [recording], Conditions(), paper)
    return evidence, [base_of(evidence, refit_trial(evidence, nominal_trial(evidence, paper)))]


def test_where_nothing_is_wanting_what_a_part_does_not_show_is_not_fitted_to_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Bent to the noise of a part, a costly force would only do harm elsewhere, in minutes."""
    evidence, bases = bases_of(nominal_model())
    known = bases[0].trial.fitted_rmse

    def not_asked(*given: object) -> None:
        raise AssertionError("fitted to all samples")

    monkeypatch.setattr(from_a_part, "_carried", not_asked)
    _, trial, why = attempt(evidence, bases, "contact", Scrutiny(2000, 2, 2.0 * known, known))
    assert trial is None
    assert "takes nothing away" in why


def test_what_a_part_shows_is_fitted_to_all() -> None:
    rig = nominal_model().with_link("contact", position=1e-5, stiffness=2e6)
    evidence, bases = bases_of(rig)
    left = bases[0].trial.fitted_rmse
    for hopeless in (2.0 * left, math.inf):
        _, trial, why = attempt(evidence, bases, "contact", Scrutiny(2000, 2, hopeless, left))
        assert trial is not None, why
        assert trial.fitted_rmse < 0.5 * left


@pytest.mark.parametrize("went_astray", [True, False])
def test_what_joins_and_is_misled_by_a_part_begins_anew_on_all(
    went_astray: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stretches do not show what creeps across them: beside friction it left twice the gap."""
    rig = nominal_model().with_link("creep").with_link("contact", position=5e-6, stiffness=5e6)
    evidence, (refit,) = bases_of(rig)
    crept = refit.trial.model.with_link("creep", **rig.values("creep"))
    base = base_of(evidence, unfitted(evidence, begun(refit, crept, ["creep"])))
    left = base.trial.fitted_rmse
    fits: list[int] = []

    def astray(evidence: Evidence, base: Base, *_: object) -> Trial:
        return replace(base.trial, fitted_rmse=5.0 * left)

    def counted(evidence: Evidence, *given: Any) -> Trial | None:  # noqa: ANN401
        fits.append(sum(map(np.count_nonzero, evidence.used)))
        return extend(evidence, *given)

    if went_astray:
        monkeypatch.setattr(from_a_part, "_carried", astray)
    monkeypatch.setattr(from_a_part, "extend", counted)
    _, trial, why = attempt(evidence, [base], "contact", Scrutiny(2000, 2, 2.0 * left, left))
    assert trial is not None, why
    assert trial.fitted_rmse < 0.5 * left
    everything = sum(map(np.count_nonzero, evidence.used))
    assert fits.count(everything) == went_astray


def test_what_a_base_made_of_the_beginning_does_not_stay() -> None:
    """A base that did not know the effect made up for it with the h that the recording began with.

    One step from there overshoots: h decays over a few volts.
    """
    rig = nominal_model().with_link("contact", position=5e-6, stiffness=5e6)
    evidence, bases = bases_of(rig)
    astray = replace(bases[0].trial, initial_hysteresis=(-5e-7,))
    right = Trial(rig, bases[0].trial.free, (), math.inf)
    whole = from_a_part._on_all(evidence, replace(bases[0], trial=astray), [right])
    assert whole is not None
    assert whole.free == right.free
    assert whole.fitted_rmse == pytest.approx(10e-9, rel=0.05)
    from_rest = 10.0 * rig.value("bouc_wen", "alpha") * rig.value("bouc_wen", "d")  # to 10 V
    assert whole.initial_hysteresis[0] == pytest.approx(from_rest, abs=1e-8)


def test_on_a_part_that_hides_some_of_the_gap_the_same_share_of_it_is_hopeless() -> None:
    """Half of what is above the floor on the whole is half of what is above it there."""
    floor, whole, part = 15e-9, 39e-9, 25e-9

    def half(of: float) -> float:
        return math.hypot(floor, 0.5 * math.sqrt(of**2 - floor**2))

    scrutiny = Scrutiny(2000, hopeless=half(whole), known=floor)
    assert scrutiny.where_shown(whole, part).hopeless == pytest.approx(half(part))
    assert scrutiny.where_shown(whole, whole).hopeless == pytest.approx(half(whole))
    assert scrutiny.where_shown(whole, 0.9 * floor).hopeless == pytest.approx(floor)


@pytest.mark.parametrize("hopeless", [30e-9, math.inf])
def test_where_the_base_itself_is_not_hopeless_nothing_changes(hopeless: float) -> None:
    scrutiny = Scrutiny(2000, hopeless=hopeless, known=15e-9)
    assert scrutiny.where_shown(25e-9, 20e-9) == scrutiny


def test_a_promise_on_stretches_is_none_of_what_their_own_beginning_takes() -> None:
    """A gain that falls in the course of a recording is no contact."""
    paper, period = nominal_model(), 1e-3
    t = period * np.arange(30_000)
    voltage = 70.0 - 60.0 * np.cos(2.0 * np.pi * 1.3 * t)
    shown = simulate(paper, voltage, period) * (1.0 - 2e-3 * t)
    noise = np.random.default_rng(4).normal(0.0, 10e-9, len(t))
    recording = Recording("run", period, voltage, shown + noise)
    evidence = Evidence.gather([recording], [recording], Conditions(), paper)
    bases = [base_of(evidence, refit_trial(evidence, nominal_trial(evidence, paper)))]
    assert promise(evidence, bases, "contact", ())[1] > 0.8


def test_a_guess_beside_which_the_model_diverges_is_none_without_a_word(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """LAPACK would print a line about numbers that are not finite."""
    problem: Any = SimpleNamespace(
        bounds=(np.full(2, -1.0), np.full(2, 1.0)), residuals=lambda z: np.ones(5)
    )
    slopes = np.ones((5, 2))
    slopes[3, 1] = np.nan
    with pytest.raises(FloatingPointError, match="diverges"):
        fitting._met_half_way(problem, np.zeros(2), slopes, np.arange(2))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("fitted", "judging", "anew"),
    [(14e-9, 67e-9, True), (14e-9, 40e-9, False), (30e-9, 67e-9, False)],
)
def test_what_follows_where_fitted_and_does_harm_where_judged_begins_from_the_nominal_model(
    monkeypatch: pytest.MonkeyPatch, fitted: float, judging: float, anew: bool
) -> None:
    """The refit leaves 50 nm where it is fitted and 60 where it is judged."""

    def creeping(fitted: float, judging: float) -> Trial:
        errors = (np.full(4, judging),)
        return Trial(nominal_model().with_link("creep"), (), (), fitted, errors)

    base, far = (
        Base(
            Trial(nominal_model(), (), (), left, (np.full(4, 60e-9),)), np.ones(4), *2 * (NOTHING,)
        )
        for left in (50e-9, 400e-9)
    )
    ends = {id(base): creeping(fitted, judging), id(far): creeping(9e-9, 12e-9)}
    evidence: Any = SimpleNamespace(scales=SCALES)
    monkeypatch.setattr(
        attempts, "on_a_part", lambda evidence, bases, name, most: (evidence, bases)
    )
    monkeypatch.setattr(attempts, "first_guesses", lambda evidence, bases, name, scrutiny: bases)
    monkeypatch.setattr(attempts, "fits_from", lambda *given: [ends[id(given[1][0])]])
    monkeypatch.setattr(attempts, "judged", lambda evidence, trial: trial)
    found, _ = attempts._attempt(evidence, [base, far], "creep", Scrutiny(15_000))
    assert found is ends[id(far) if anew else id(base)]
    assert attempts._attempt(evidence, [base], "creep", Scrutiny(15_000))[0] is ends[id(base)]
