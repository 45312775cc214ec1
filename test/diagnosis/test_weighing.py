"""The weighing of explanations, on errors written down by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from microgripper_control.diagnosis.answers.answer import (
    ambiguous,
    by_importance,
    candidates,
    chosen,
    rivals,
    verdict,
)
from microgripper_control.diagnosis.answers.weighing import (
    AGREES,
    MISTUNED,
    NOTHING,
    OUTSIDE,
    Facts,
    Left,
    explained,
    weigh,
)
from microgripper_control.diagnosis.data.grid import NO_GRID, Grid
from microgripper_control.diagnosis.findings import EFFECTS, UNKNOWN
from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.effects.base import Scales
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, nominal_model

NM = 1e-9
CREEP, LAG, BOTH = (
    frozenset(["creep"]),
    frozenset(["sensor_lag"]),
    frozenset(["creep", "sensor_lag"]),
)
SCALES = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (-1e-5, 1e-5), 5e7, 0.0038)
EVIDENCE = SimpleNamespace(grid=NO_GRID, scales=SCALES, rounded=False)  # all that is looked at


def on_grid(step: float, known: bool = False) -> SimpleNamespace:
    """The same of readings on steps, m, that the model has if they are `known`."""
    return SimpleNamespace(grid=Grid.even(step), rounded=known)


def facts(nominal: float, refit: float, **tried: float) -> Facts:
    names = {"creep": CREEP, "lag": LAG, "both": BOTH}
    errors = {names[name]: alike(error) for name, error in tried.items()}
    return Facts(alike(nominal), alike(refit), 15.0 * NM, 500.0, errors)


def alike(error: float) -> Left:
    """The same error, nm, on the judging and on the fitted samples."""
    return Left(error * NM, error * NM)


def test_a_candidate_is_noted_for_the_values_that_it_shows() -> None:
    """A play by itself runs into its bound; beside the delay that is there as well, it does not."""
    evidence = SimpleNamespace(
        grid=NO_GRID, scales=SCALES, rounded=False, nominal=nominal_model(), fitted=()
    )
    play = registry()["backlash"].parameter("play")
    bound = registry()["backlash"].plausible(SCALES).get("play", (play.low, play.high))[1]
    noise = (15.0 * NM * np.random.default_rng(2).standard_normal(2000),)
    nothing = Trial(nominal_model(), (), (), 90.0 * NM, noise)
    alone = Trial(nominal_model().with_link("backlash", play=bound), (), (), 20.0 * NM, noise)
    pool = Pool(evidence, nothing, nothing)  # type: ignore[arg-type]
    both = frozenset(["backlash", "transport_delay"])
    pool.tried = {frozenset(["backlash"]): alone, both: alone}
    model = nominal_model().with_link("backlash", play=6e-7).with_link("transport_delay")
    for shown, noted in ((model, False), (nominal_model(), True)):
        found = candidates({both: 1.0}, pool, sorted(both), [], shown)
        (own,) = (candidate for candidate in found if candidate.effect == "backlash")
        assert (own.parameters["play"].value == bound) == noted
        assert ("play at its bound" in own.note) == noted


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (facts(15.01, 15.0, creep=15.0, lag=14.99), NOTHING),
        (facts(300.0, 15.0, creep=15.0, lag=14.99), MISTUNED),
        (facts(300.0, 60.0, creep=15.5, lag=50.0), CREEP),
        (facts(300.0, 60.0, creep=50.0, lag=52.0), OUTSIDE),
        (facts(300.0, 60.0, creep=44.0, lag=45.0, both=15.5), BOTH),
        (facts(300.0, 60.0, creep=15.5, lag=50.0, both=15.4), CREEP),
    ],
)
def test_the_plain_answer_wins(given: Facts, expected: frozenset[str]) -> None:
    weighed = weigh(given)
    assert sum(weighed.values()) == pytest.approx(1.0)
    assert max(weighed, key=lambda explanation: weighed[explanation]) == expected


def test_a_gain_that_leaves_less_than_a_drift_is_no_drift() -> None:
    drift = frozenset(["thermal_drift"])
    given = replace(facts(300.0, 200.0), tried={drift: alike(35.0)})
    assert weigh(given)[drift] > weigh(given)[OUTSIDE]
    for left, is_drift in ((16.0, False), (34.0, True)):
        beside = replace(given, gains={drift: alike(left)})
        weighed = weigh(beside)
        assert (weighed[drift] > weighed[OUTSIDE]) == is_drift
        assert beside.slow_gain != is_drift


def test_an_unknown_law_is_held_against_the_model_as_given_if_a_refit_foretells_worse() -> None:
    bent = replace(facts(36.0, 40.0), refit=Left(106.0 * NM, 35.0 * NM))
    assert weigh(bent)[OUTSIDE] > weigh(bent)[NOTHING]


def test_of_equally_good_explanations_the_one_of_its_usual_size_is_believed() -> None:
    both = facts(300.0, 60.0, creep=15.5, lag=15.5)
    weighed = weigh(replace(both, unusual={CREEP: 1.0, LAG: 0.0}))
    assert weighed[LAG] == pytest.approx(np.exp(2.0) * weighed[CREEP])


def test_equally_good_explanations_share_the_probability() -> None:
    weighed = weigh(facts(300.0, 60.0, creep=15.5, lag=15.5))
    assert weighed[CREEP] == pytest.approx(weighed[LAG])
    assert weighed[CREEP] > 0.4


def test_of_two_that_close_the_gap_the_one_that_leaves_noise_alone_is_believed() -> None:
    """3 % over the noise is little of a gap of thirty times the noise, but not nothing."""
    weighed = weigh(facts(900.0, 450.0, creep=15.0, lag=15.5))
    assert weighed[CREEP] > 1.5 * weighed[LAG]


def test_of_equally_good_explanations_the_one_with_fewer_parameters_is_believed() -> None:
    equal = facts(300.0, 60.0, creep=15.5, lag=15.5)
    weighed = weigh(replace(equal, beyond={CREEP: 2, LAG: -1}))
    assert weighed[LAG] == pytest.approx(np.exp(0.45) * weighed[CREEP])


def test_the_sign_of_a_lag_does_not_decide_between_lags() -> None:
    late = [AGREES[name] for name in ("amplifier_lag", "transport_delay", "sensor_lag")]
    assert np.ptp(late) < 0.2


def test_samples_beyond_the_cap_add_no_certainty() -> None:
    few, many = (
        replace(facts(300.0, 60.0, creep=20.0, lag=22.0), independent=count) for count in (1e3, 1e6)
    )
    assert weigh(few) == weigh(many)


def test_a_signature_tips_the_scales() -> None:
    plain = facts(300.0, 60.0, creep=16.0, lag=16.0)
    signed = replace(plain, signs={"creep": True, "sensor_lag": False})
    assert weigh(signed)[CREEP] > weigh(plain)[CREEP] > weigh(signed)[LAG]


def test_a_signature_counts_for_what_it_has_proved_to_be_worth() -> None:
    """A line at the mains has no other cause; the residual bends for many reasons."""
    hum, bend = frozenset(["mains_hum"]), frozenset(["saturation"])
    left = Left(16.0 * NM, 16.0 * NM)
    plain = Facts(
        Left(300.0 * NM, 300.0 * NM),
        Left(60.0 * NM, 60.0 * NM),
        15.0 * NM,
        20.0,
        {hum: left, bend: left},
    )
    assert weigh(plain)[hum] == weigh(plain)[bend]
    both = weigh(replace(plain, signs={"mains_hum": True, "saturation": True}))
    assert both[hum] / both[bend] == pytest.approx(np.exp(2.6 - 0.8))
    assert set(AGREES) <= set(registry())


def test_an_effect_that_shows_in_the_fitted_samples_only_is_believed() -> None:
    """A slow held-out run says nothing about a slew limit; the fast ones that were fitted do."""
    quiet = Facts(Left(16.0 * NM, 90.0 * NM), Left(15.1 * NM, 60.0 * NM), 15.0 * NM, 500.0, {})
    weighed = weigh(replace(quiet, tried={CREEP: Left(15.1 * NM, 16.0 * NM)}))
    assert max(weighed, key=lambda explanation: weighed[explanation]) == CREEP


def test_what_fits_and_does_not_predict_is_not_believed() -> None:
    weighed = weigh(replace(facts(300.0, 60.0), tried={CREEP: Left(120.0 * NM, 30.0 * NM)}))
    assert weighed[CREEP] < 0.01


def test_a_grid_counts_for_what_it_rounds_though_its_prediction_is_no_closer() -> None:
    """Step 200 nm: 58 nm rms of rounding are all of the gap; a drift that takes half is less."""
    model = nominal_model()
    grid = model.with_link("sensor_quantization", resolution=200.0 * NM)
    pool = pool_of(
        {
            frozenset(["sensor_quantization"]): trial(grid, 62.0),
            frozenset(["thermal_drift"]): trial(model.with_link("thermal_drift"), 40.0),
        }
    )
    pool.evidence = on_grid(200.0 * NM)  # type: ignore[assignment]
    both = frozenset(["thermal_drift", "sensor_quantization"])
    assert by_importance(both, pool) == ("sensor_quantization", "thermal_drift")


def test_a_gap_that_only_the_judging_samples_show_is_a_gap() -> None:
    """The fitted ones are quieter than the floor of the judging ones: that is no merit."""
    shown = Facts(Left(560.0 * NM, 90.0 * NM), Left(350.0 * NM, 9.0 * NM), 19.0 * NM, 10.0, {})
    weighed = weigh(shown)
    assert max(weighed, key=lambda explanation: weighed[explanation]) == OUTSIDE


def test_rounding_is_no_noise_once_its_grid_is_known() -> None:
    """15 nm under steps of 52 nm: 21 nm of innovation, and a bow that cannot be told."""
    model, step = nominal_model(), 52.0 * NM
    seen = float(np.hypot(15.0 * NM, step / np.sqrt(12.0)))
    white = seen * np.random.default_rng(3).standard_normal(20_000)
    left = Trial(model, (), (), seen, (white,))
    pool = Pool(on_grid(step), left, left)  # type: ignore[arg-type]
    assert pool.noise_floor == pytest.approx(seen, rel=0.02)
    grid = replace(left, model=model.with_link("sensor_quantization", resolution=step))
    pool.tried[frozenset(["sensor_quantization"])] = grid
    assert pool.noise_floor == pytest.approx(np.sqrt(15.0**2 - (0.15 * 52.0) ** 2) * NM, rel=0.05)


def test_a_grid_that_the_model_has_rounds_beside_any_explanation() -> None:
    model, step = nominal_model(), 52.0 * NM
    seen = float(np.hypot(15.0 * NM, step / np.sqrt(12.0)))
    white = seen * np.random.default_rng(3).standard_normal(20_000)
    left = Trial(model, (), (), seen, (white,))
    pool = Pool(on_grid(step, known=True), left, left)  # type: ignore[arg-type]
    unbowed = np.sqrt(15.0**2 - (0.15 * 52.0) ** 2) * NM
    assert pool.noise_floor == pytest.approx(unbowed, rel=0.05)
    assert explained(frozenset(), left, pool).both == pytest.approx(unbowed, rel=0.05)


def test_noise_below_a_coarse_grid_is_still_noise() -> None:
    """15 nm on steps of 48 nm: held in the middle of a step, most readings bring nothing new."""
    step, errors = 48.0 * NM, []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        held = np.repeat(rng.uniform(0.0, 1e-5, 12), 2000)
        noisy = held + 15.0 * NM * rng.standard_normal(len(held))
        errors.append(step * np.rint(noisy / step) - held)
    grid = nominal_model().with_link("sensor_quantization", resolution=step)
    left = Trial(grid, (), (), 15.0 * NM, tuple(errors))
    assert left.quietest < 0.95 * left.noise_floor
    pool = Pool(on_grid(step), left, left)  # type: ignore[arg-type]
    pool.tried[frozenset(["sensor_quantization"])] = left
    assert pool.noise_floor == pytest.approx(np.sqrt(15.0**2 - (0.15 * 48.0) ** 2) * NM, rel=0.1)


def test_what_a_law_leaves_at_steps_is_no_noise() -> None:
    """15 nm of noise, and jumps of 1 um in every hundredth sample; a grid of 70 nm would be 20."""
    rng = np.random.default_rng(3)
    left = 15.0 * NM * rng.standard_normal(20_000)
    left[::100] += 1000.0 * NM * rng.standard_normal(200)
    model = nominal_model()
    one = Trial(model, (), (), 100.0 * NM, (left,))
    assert one.noise_floor > 90.0 * NM
    pool = Pool(EVIDENCE, one, one)  # type: ignore[arg-type]
    assert pool.noise_floor == pytest.approx(15.0 * NM, rel=0.05)
    pool = Pool(on_grid(70.0 * NM), one, one)  # type: ignore[arg-type]
    assert pool.noise_floor == pytest.approx(70.0 * NM / np.sqrt(12.0))


@pytest.mark.parametrize(("error", "kept"), [(60.0, True), (40.0, False)])
def test_a_grid_is_dropped_if_an_explanation_follows_the_readings_more_closely(
    error: float, kept: bool
) -> None:
    """Steps of 200 nm leave 58 nm rms, whatever the model."""
    model = nominal_model()
    grid = frozenset(["sensor_quantization"])
    noisy = SimpleNamespace(measured=np.random.default_rng(4).standard_normal(2000))
    seen = SimpleNamespace(fitted=[noisy], grid=Grid.even(200.0 * NM), rounded=False)
    pool = Pool(seen, trial(model, 90.0), trial(model, 90.0))  # type: ignore[arg-type]
    pool.tried[grid] = trial(model.with_link("sensor_quantization", resolution=200.0 * NM), 95.0)
    pool.tried[CREEP] = trial(model.with_link("creep"), error)
    pool.drop_idle_grid()
    assert (grid in pool.tried) == kept
    assert ("sensor_quantization" in pool.failures) != kept


@pytest.mark.parametrize(("steps", "kept"), [(2.0, False), (2.2, False), (3.0, True), (3.9, True)])
def test_a_grid_is_dropped_if_its_steps_hardly_add_to_the_noise(steps: float, kept: bool) -> None:
    """20 nm of noise under steps of so many times that: an error of 1.15, 1.18, 1.32, 1.5 times."""
    grid = frozenset(["sensor_quantization"])
    step = steps * 20.0 * NM
    model = nominal_model()
    seen = float(np.hypot(20.0 * NM, step / np.sqrt(12.0)))
    white = seen * np.random.default_rng(6).standard_normal(20_000)
    left = Trial(model, (), (), seen, (white,))
    noisy = SimpleNamespace(measured=white)
    known = SimpleNamespace(fitted=[noisy], grid=Grid.even(step), rounded=False, nominal=model)
    pool = Pool(known, left, left)  # type: ignore[arg-type]
    behind = replace(left, model=model.with_link("sensor_quantization", resolution=step))
    pool.tried |= {grid: behind, CREEP | grid: behind, CREEP: left}
    pool.drop_idle_grid()
    assert set(pool.tried) == ({grid, CREEP | grid, CREEP} if kept else {CREEP})
    assert ("sensor_quantization" in pool.failures) != kept


@pytest.mark.parametrize(("lag", "groups"), [(16.5, (("creep", "sensor_lag"),)), (17.5, ())])
def test_only_what_leaves_about_as_much_is_a_group(lag: float, groups: object) -> None:
    """Nearly as probable; but where half of the noise more is left, the two are told apart."""
    model = nominal_model()
    pool = pool_of(
        {
            CREEP: trial(model.with_link("creep"), 15.0),
            LAG: trial(model.with_link("sensor_lag"), lag),
        }
    )
    assert ambiguous({CREEP: 0.5, LAG: 0.45, NOTHING: 0.05}, pool) == groups
    assert ambiguous({CREEP: 0.6, LAG: 0.3, NOTHING: 0.1}, pool) == ()


@pytest.mark.parametrize(("lag", "kind"), [(16.0, EFFECTS), (40.0, UNKNOWN)])
def test_effects_that_stand_for_each_other_outweigh_the_unknown_together(
    lag: float, kind: str
) -> None:
    """Each for itself is less probable than a law outside the library."""
    model = nominal_model()
    pool = pool_of(
        {
            CREEP: trial(model.with_link("creep"), 15.0),
            LAG: trial(model.with_link("sensor_lag"), lag),
        }
    )
    assert verdict({CREEP: 0.3, LAG: 0.25, OUTSIDE: 0.45}, pool) == kind


@pytest.mark.parametrize(("with_both", "named"), [(0.45, CREEP), (0.65, BOTH)])
def test_a_further_effect_is_named_if_it_is_worth_much_more(
    with_both: float, named: frozenset[str]
) -> None:
    """Beside 0.1 for creep alone."""
    model = nominal_model()
    creep, lag = model.with_link("creep"), model.with_link("sensor_lag")
    pool = pool_of(
        {
            CREEP: trial(creep, 20.0),
            LAG: trial(lag, 50.0),
            BOTH: trial(creep.with_link("sensor_lag"), 15.0),
        }
    )
    assert chosen({CREEP: 0.1, LAG: 0.01, BOTH: with_both, NOTHING: 0.2}, pool) == named


@pytest.mark.parametrize(
    ("left", "with_both", "named"), [(22.0, 0.2, BOTH), (32.0, 0.2, CREEP), (22.0, 0.08, CREEP)]
)
def test_a_second_effect_is_named_if_it_takes_most_of_the_rest(
    left: float, with_both: float, named: frozenset[str]
) -> None:
    """Creep alone leaves 40 nm and is as probable as 0.1; the noise is 15 nm."""
    model = nominal_model()
    creep, lag = model.with_link("creep"), model.with_link("sensor_lag")
    both = creep.with_link("sensor_lag")
    pool = pool_of({CREEP: trial(creep, 40.0), LAG: trial(lag, 50.0), BOTH: trial(both, left)})
    quiet = frozenset(["creep", "mains_hum"])
    pool.tried[quiet] = trial(creep.with_link("mains_hum"), 15.0)
    weighed = {CREEP: 0.1, LAG: 0.01, BOTH: with_both, quiet: 0.0, NOTHING: 0.2}
    assert chosen(weighed, pool) == named


def test_the_model_as_given_is_no_rival_beside_its_refit() -> None:
    pool = pool_of({CREEP: trial(nominal_model().with_link("creep"), 15.0)})
    for weighed, expected in (
        ({CREEP: 0.4, MISTUNED: 0.3, NOTHING: 0.3}, [pool.tried[CREEP], pool.refit]),
        ({MISTUNED: 0.6, NOTHING: 0.4}, [pool.refit]),
        ({CREEP: 0.5, MISTUNED: 0.001, NOTHING: 0.499}, [pool.tried[CREEP], pool.nominal]),
    ):
        assert [id(one) for one in rivals(weighed, pool)] == [id(one) for one in expected]


def test_an_effect_that_was_fitted_away_beside_another_is_no_explanation() -> None:
    creep = nominal_model().with_link("creep")
    gone = creep.with_link("sensor_lag", averaging=0.0, time_constant=0.0, curvature=0.0, clock=0.0)
    at_work = creep.with_link("sensor_lag")
    for model, weighed in ((gone, {CREEP}), (at_work, {CREEP, BOTH})):
        pool = pool_of({CREEP: trial(creep, 20.0), BOTH: trial(model, 20.0)})
        assert Facts.of(pool).tried.keys() == weighed


def pool_of(tried: Mapping[frozenset[str], Trial]) -> Pool:
    """What was tried where the model as it is, and refitted, leaves 60 nm."""
    given, refit = trial(nominal_model(), 60.0), trial(nominal_model(), 60.0)
    return Pool(EVIDENCE, given, refit, dict(tried))  # type: ignore[arg-type]


def trial(model: Model, error: float) -> Trial:
    white = np.random.default_rng(2).choice([-error * NM, error * NM], 400)
    return Trial(model, (), (), error * NM, (white,))


def test_what_is_left_counts_most_against_a_drift_and_least_against_a_hysteresis() -> None:
    """All else alike, even where a fifth of the gap is left."""
    names = ("restoring_force_hysteresis", "creep", "thermal_drift")
    left = {frozenset([name]): alike(25.0) for name in names}
    weighed = weigh(Facts(alike(110.0), alike(100.0), 15.0 * NM, 500.0, left))
    probable = [weighed[frozenset([name])] for name in names]
    assert probable[0] > 1.2 * probable[1] > 1.4 * probable[2]
    whole = {effects: alike(15.0) for effects in left}  # down to the floor nothing is left
    weighed = weigh(Facts(alike(110.0), alike(100.0), 15.0 * NM, 500.0, whole))
    assert weighed[frozenset(["creep"])] == pytest.approx(weighed[frozenset(["thermal_drift"])])
