"""Whole cases: their truth, their files, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rig_runs import rms
from scipy.signal import resample

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.plant.model_file import load_model
from microgripper_control.recordings.read import read_recording
from microgripper_control.validation.base import ACTUATORS
from microgripper_control.validation.case import DEVELOPMENT_SEEDS, REPORTING_SEEDS, Case, make_case
from microgripper_control.validation.case_files import write_case
from microgripper_control.validation.drive import KNOTS
from microgripper_control.validation.excitation import (
    EXCITATIONS,
    hold_setting,
    open_loop,
    plans,
    suited,
)
from microgripper_control.validation.laboratory import equipped
from microgripper_control.validation.rivals import rival, without
from microgripper_control.validation.sizing import shape_of

QUICK = 1385  # a seed with few and short recordings


@pytest.fixture(scope="module")
def contact() -> Case:
    return make_case("blind", ["contact"], "a", "medium", "decaying", QUICK)


def test_a_case_has_the_strength_that_was_asked_for(contact: Case) -> None:
    (cause,) = contact.truth.causes
    assert contact.truth.ratio == pytest.approx(5.0, rel=0.1)
    assert cause.ratio == pytest.approx(contact.truth.ratio, rel=1e-9)
    assert (contact.truth.verdict, cause.reached, cause.seen) == ("effects", True, True)
    errors = contact.truth.errors_m
    assert errors["oracle"]["all"] == pytest.approx(contact.noise, rel=0.03)
    assert errors["nominal"]["all"] > errors["refit"]["all"] > errors["oracle"]["all"]


def test_the_place_is_where_the_contact_is_as_the_sensor_shows_it(contact: Case) -> None:
    (place,) = contact.truth.causes[0].where
    scale = contact.actuator.scale
    zero = np.mean(list(contact.truth.zeros_m.values()))
    touch = scale.displacement(contact.truth.causes[0].shape["position"])
    assert (place.axis, place.low) == ("displacement_m", pytest.approx(touch + zero))
    highest = max(one.measured.max() for one in contact.recordings)
    assert place.high == pytest.approx(highest, abs=2e-7)


def test_the_seed_decides_everything(contact: Case) -> None:
    again = make_case("blind", ["contact"], "a", "medium", "decaying", QUICK)
    assert again.truth == contact.truth
    for one, other in zip(contact.recordings, again.recordings, strict=True):
        assert np.array_equal(one.measured, other.measured)
        assert np.array_equal(one.drive.samples, other.drive.samples)
    other = equipped(QUICK + 1, "decaying")
    assert other.base != contact.rig.base


def test_the_rig_is_mistuned_by_at_most_fifteen_per_cent(contact: Case) -> None:
    off = list(contact.truth.mistuning.values())
    assert len(off) == 8
    assert all(0.0 < abs(value) <= 0.15 for value in off)


def test_files_are_the_package_s_own_and_tell_nothing(contact: Case, tmp_path: Path) -> None:
    folder, seal = tmp_path / "case", tmp_path / "sealed" / "truth.json"
    write_case(contact, folder, seal)
    tables = {f"{taken.name}.csv" for taken in contact.recordings}
    assert {path.name for path in folder.iterdir()} == {"job.json", "model.yaml", *tables}
    text = "".join(path.read_text(encoding="utf-8") for path in folder.glob("*.[jy]*"))
    assert "contact" not in text
    assert "seed" not in text
    model = load_model(folder / "model.yaml")
    assert model.value("bouc_wen", "d") == contact.actuator.base.d
    assert model.voltage_range == (contact.actuator.low, contact.actuator.high)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    assert job["hold"] == contact.hold
    assert set(job["recordings"] + job["heldout"]) == tables
    taken = contact.recordings[0]
    read = read_recording(folder / f"{taken.name}.csv")
    assert read.sample_period == pytest.approx(taken.drive.sample_period)
    assert read.voltage == pytest.approx(taken.drive.recorded, rel=1e-9, abs=1e-9)
    assert read.measured == pytest.approx(taken.measured, abs=1e-16)
    truth = json.loads(seal.read_text(encoding="utf-8"))
    assert truth["effects"] == ["contact"]
    assert truth["causes"][0]["where"][0]["axis"] == "displacement_m"


def test_without_any_cause_the_nominal_model_or_a_refit_leaves_the_noise() -> None:
    none = make_case("blind", ["none"], "a", "weak", "decaying", QUICK).truth
    assert none.verdict == "none"
    assert none.errors_m["nominal"]["all"] == pytest.approx(none.noise_m, rel=0.03)
    off = make_case("blind", ["parameters"], "a", "weak", "decaying", QUICK).truth
    assert off.verdict == "parameters"
    assert off.errors_m["refit"]["heldout"] == pytest.approx(off.noise_m, rel=0.05)
    assert off.errors_m["nominal"]["all"] > 2.0 * off.noise_m


def test_what_recordings_cannot_show_is_labelled_unseen() -> None:
    truth = make_case("blind", ["extra_resonance"], "a", "weak", "poor", 168).truth
    assert not truth.causes[0].seen
    assert truth.ratio < 1.2
    assert truth.verdict == "parameters"


def test_two_causes_are_both_there_and_the_oracle_misses_either() -> None:
    case = make_case("pairs", ["mains_hum", "saturation"], "a", "medium", "decaying", QUICK)
    assert [cause.effect for cause in case.truth.causes] == ["mains_hum", "saturation"]
    assert case.truth.ratio > 5.5
    for cause in case.truth.causes:
        assert without(case, cause.effect).errors["heldout"] > 2.0 * case.noise


def test_a_rival_is_told_by_its_excess_and_the_true_one_has_none() -> None:
    case = make_case("never", ["sensor_polynomial"], "a", "medium", "decaying", QUICK)
    true, other = rival(case, "sensor_polynomial"), rival(case, "supply_sag")
    assert true is not None
    assert other is not None
    assert true.excess < 0.3
    assert other.excess > 3.0
    assert rival(case, "mains_hum") is None


def test_foreign_causes_are_unknown() -> None:
    truth = make_case("never", ["cyclic_error"], "b", "medium", "decaying", 100_157).truth
    assert truth.verdict == "unknown"
    assert not truth.causes[0].in_library


@pytest.mark.parametrize("excitation", EXCITATIONS)
@pytest.mark.parametrize("smooth", [False, True])
def test_recordings_are_such_as_a_laboratory_makes(excitation: str, smooth: bool) -> None:
    if excitation == "tracking" and smooth:
        return
    for seed in range(4):
        laboratory = equipped(seed, excitation)
        actuator = laboratory.actuator
        made = plans(excitation, actuator, 1e-3, smooth, np.random.default_rng(seed))
        names = [plan.name for plan in made]
        assert 1 <= sum(name.startswith("recording") for name in names) <= 3
        assert 1 <= sum(name.startswith("heldout") for name in names) <= 2
        assert sum(plan.wave.duration for plan in made) <= 60.0 * 1.0001
        for plan in made:
            assert 5.0 <= plan.wave.duration <= 60.0
            drive = open_loop(plan, actuator, 1e-3, smooth)
            assert drive.samples.min() >= actuator.low - 1e-9
            assert drive.samples.max() <= actuator.high + 1e-9
            assert (drive.samples[0] == pytest.approx(0.0, abs=1e-9)) or plan.closed_loop


@pytest.mark.parametrize("excitation", EXCITATIONS)
def test_a_brief_case_has_fewer_samples(excitation: str) -> None:
    for seed in range(8):
        usual, brief = equipped(seed, excitation), equipped(seed, excitation, brief=True)
        durations = [plan.wave.duration for plan in brief.plans]
        assert len(usual.plans) >= len(brief.plans) in (2, 3)
        assert sum(durations) / brief.sample_period <= 20_000
        assert min(durations) >= 5.0
        again = equipped(seed, excitation, like=brief)
        assert [plan.wave.duration for plan in again.plans] == durations


@pytest.mark.parametrize("excitation", ["loops", "staircase", "mixed", "multisine"])
def test_the_hold_that_is_told_is_true_of_a_smooth_voltage(excitation: str) -> None:
    for seed in range(3):
        made = plans(excitation, ACTUATORS[0], 1e-3, True, np.random.default_rng(seed))
        for plan in made:
            drive = open_loop(plan, ACTUATORS[0], 1e-3, True)
            assert drive.knots is not None
            middle = drive.knots[KNOTS // 2 :: KNOTS][:-1]
            if hold_setting([one.wave for one in made], 1e-3, True) == "first":
                found = 0.5 * (drive.samples[1:] + drive.samples[:-1])
            else:
                count = len(drive.recorded)
                line = np.linspace(drive.recorded[0], drive.recorded[-1], count)
                twice = resample(drive.recorded - line, 2 * count)[1::2][:-1]
                found = twice + 0.5 * (line[1:] + line[:-1])
                middle = middle[-len(found) :]
            # What is missed moves the finger by less than any sensor's noise.
            missed = rms(found - middle) * ACTUATORS[0].base.d
            assert missed < 1e-9


def test_a_closed_loop_tracks_and_answers_the_effect() -> None:
    laboratory = replace(equipped(21, "tracking"), sample_period=2e-3)
    laboratory = replace(laboratory, plans=laboratory.plans[:1])
    (bare,) = laboratory.record((), 208)
    plan, scale = laboratory.plans[0], laboratory.actuator.scale
    times = 2e-3 * np.arange(len(bare.measured))
    wanted = scale.bottom + scale.stroke * plan.wave.share(times)
    miss = (bare.measured - laboratory.zeros[0] - wanted)[2000:]
    assert np.median(np.abs(miss)) < 0.02 * scale.stroke


def test_each_effect_has_excitations_that_show_it() -> None:
    assert "poor" not in suited("creep")
    assert set(suited("extra_resonance")) < set(suited("creep")) < set(EXCITATIONS)


def test_shapes_depend_on_the_seed_and_stay_in_their_ranges() -> None:
    one, other = shape_of("contact", "a", 1), shape_of("contact", "a", 2)
    assert one != other
    assert 0.5 <= one["position"] <= 0.8


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("blind", ["creeep"], "a", "weak", "loops", 1), "creeep"),
        (("sighted", ["creep"], "a", "weak", "loops", 1), "sighted"),
        (("blind", ["creep"], "c", "weak", "loops", 1), "'c'"),
        (("blind", ["creep"], "a", "faint", "loops", 1), "faint"),
        (("blind", ["creep"], "a", "weak", "wobble", 1), "wobble"),
        (("blind", ["creep"], "b", "weak", "loops", 1), "kept for reporting"),
        (("blind", ["creep"], "a", "weak", "loops", 50_000), "50000"),
        (("blind", ["ageing"], "a", "weak", "loops", 1), "ageing"),
        (("never", ["creep"], "a", "weak", "loops", 1), "creep"),
        (("pairs", ["creep"], "a", "weak", "loops", 1), "2 effects"),
        (("withheld", ["none"], "a", "weak", "loops", 1), "none"),
    ],
)
def test_what_makes_no_case_is_refused_by_name(arguments: tuple, named: str) -> None:
    with pytest.raises(MicrogripperError, match=named):
        make_case(*arguments)


def test_development_and_reporting_share_no_seed() -> None:
    assert set(DEVELOPMENT_SEEDS).isdisjoint({REPORTING_SEEDS[0]})
    assert DEVELOPMENT_SEEDS[-1] < REPORTING_SEEDS[0]
