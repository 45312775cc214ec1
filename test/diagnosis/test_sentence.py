"""The verdict in words: every effect's clause holds its numbers in practical units."""

from __future__ import annotations

from dataclasses import replace

import pytest

from microgripper_control.diagnosis.answers.driven import most_driven
from microgripper_control.diagnosis.answers.sentence import described, sentence
from microgripper_control.diagnosis.findings import (
    EFFECTS,
    NONE,
    PARAMETERS,
    UNKNOWN,
    Candidate,
    Gap,
    Range,
)
from microgripper_control.effects.base import Scales, no_starts
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, Setting, nominal_model

SCALES = Scales(1e-3, 44.0, (0.0, 160.0), 500.0, (0.0, 20e-6), 5e7, 0.0038, 1e-6)
GAP = Gap(90e-9, 69e-9, 17e-9, 15e-9, 0.881, 0.84, 0.91, 0.82, True)
PAPER = nominal_model()

CLAUSES = [
    ("amplifier_lag", {"lag": 5.2e-4, "curvature": 0.0}, ["amplifier", "520 µs", "first order"]),
    ("amplifier_lag", {"lag": 2.5e-3, "curvature": 0.25}, ["2.5 ms", "second order"]),
    (
        "slew_limit",
        {"time": 4.5e-5, "asymmetry": -0.5 / 4.5},
        ["rises by 25000 V/s at most", "falls by 20000 V/s"],
    ),
    ("slew_limit", {"time": 2e-3, "asymmetry": 1.0}, ["voltage rises by 250 V/s at most"]),
    (
        "saturation",
        {"low": -1e4, "high": 148.0, "low_softness": 0.5, "high_softness": 0.5},
        ["saturates above 148 V"],
    ),
    (
        "saturation",
        {"low": 12.0, "high": 1e4, "low_softness": 8.0, "high_softness": 8.0},
        ["softly below 12.0 V"],
    ),
    ("transport_delay", {"delay": 2.7e-3}, ["a delay of 2.7 ms"]),
    ("creep", {"strength": 0.012}, ["1.2 % of the step per decade of time"]),
    ("creep", {"strength": 0.02, "fastest": 1.0, "slowest": 4.0}, ["1.2 % of", "within some 2 s"]),
    ("rate_dependent_hysteresis", {"strength": 0.08}, ["widens by 8.0 % per decade of rate"]),
    ("rate_dependent_hysteresis", {"strength": -0.08}, ["narrows by 8.0 %"]),
    (
        "rate_dependent_hysteresis",
        {"strength": 0.01, "late": 0.3, "memory": 4e-3},
        ["narrows by 30 % where the voltage changes within 4 ms"],
    ),
    (
        "asymmetric_hysteresis",
        {"tilt": 1e-9, "bulge": 0.0, "twist": 0.0, "skew": 0.0},
        ["lopsided", "%"],
    ),
    ("nonlinear_stiffness", {"quadratic": 5e10, "cubic": 0.0}, ["stiffens by 4.0 %"]),
    ("nonlinear_stiffness", {"quadratic": 0.0, "cubic": -2.5e15}, ["softens by 6.0 %"]),
    ("contact", {"position": 15.2e-6}, ["beyond x = 15.2 µm", "2.0 N for each µm"]),
    ("contact", {"position": 2e-6, "side": -1.0, "exponent": 1.5}, ["below x = 2.00 µm", "depth"]),
    ("friction", {"coulomb": 12.0, "stiffness": 2e7, "excess": 0.0}, ["600 nm", "12 N"]),
    (
        "restoring_force_hysteresis",
        {"alpha": 2e6, "beta": 5e5, "gamma": 1e5},
        ["6.7 % stiffer", "5.0 µm"],
    ),
    ("backlash", {"play": 2.1e-7}, ["play", "210 nm"]),
    ("extra_resonance", {"frequency": 212.4, "damping": 0.021}, ["212 Hz", "ratio 0.021"]),
    ("sensor_lag", {"averaging": 2e-3, "time_constant": 0.0}, ["averages over 2.0 ms"]),
    (
        "sensor_lag",
        {"averaging": 0.0, "time_constant": 2e-3},
        ["time constant of 2.0 ms (first order)"],
    ),
    (
        "sensor_lag",
        {"averaging": 1e-3, "time_constant": 2e-3, "curvature": 0.5},
        ["averages over 1.0 ms and has a time constant of 2.0 ms (second order)"],
    ),
    ("sensor_quantization", {"resolution": 1e-6}, ["steps of 1.0 µm"]),
    ("thermal_drift", {}, ["drifts", "whatever the voltage does"]),
    ("mains_hum", {"frequency": 49.98}, ["50.0 Hz"]),
]


def with_effect(model: Model, name: str, **values: float) -> Model:
    return model.with_link(name, **values)


def candidate(name: str, rmse: float, **values: float) -> Candidate:
    settings = with_effect(PAPER, name, **values).settings[name]
    return Candidate(name, registry()[name].stage.value, 0.5, 0.5, rmse, settings)


@pytest.mark.parametrize(("name", "values", "expected"), CLAUSES, ids=lambda case: str(case)[:40])
def test_a_clause_holds_its_numbers(
    name: str, values: dict[str, float], expected: list[str]
) -> None:
    clause = described(name, with_effect(PAPER, name, **values).values(name), SCALES)
    for part in expected:
        assert part in clause
    assert clause[0].islower()
    assert not clause.endswith(".")


def test_every_effect_that_is_diagnosed_has_a_clause_of_its_own() -> None:
    diagnosed = {name for name, link in registry().items() if link.starts is not no_starts}
    assert diagnosed == {name for name, *_ in CLAUSES}
    assert all(registry()[name].says for name in diagnosed)


def test_an_effect_without_a_clause_is_called_by_its_title() -> None:
    values = {p.name: p.nominal for p in registry()["sensor_noise"].parameters}
    assert described("sensor_noise", values, SCALES) == "the rig shows sensor noise"


def test_the_issues_own_example() -> None:
    model = with_effect(PAPER, "creep", strength=0.012)
    said = sentence(EFFECTS, ["creep"], GAP, PAPER, model, [], [], SCALES)
    assert said == (
        "The rig creeps: after a step it goes on moving by 1.2 % of the step per decade of time. "
        "Adding creep takes the held-out error from 69 nm to 17 nm (noise floor 15 nm): "
        "88 % [84, 91] of what could be removed."
    )


def test_a_grid_that_foretells_nothing_is_not_said_to_close_the_gap() -> None:
    model = with_effect(PAPER, "sensor_quantization", resolution=5.2e-8)
    gap = replace(GAP, refit=23e-9, augmented=31e-9, closed=-0.55)
    said = sentence(EFFECTS, ["sensor_quantization"], gap, PAPER, model, [], [], SCALES)
    assert said == (
        "The sensor is coarse: it shows steps of 52 nm. That is 17 nm of the held-out error of "
        "23 nm (noise floor 15 nm); which way a reading is rounded, no model foretells."
    )


def test_two_effects_are_both_told() -> None:
    model = with_effect(with_effect(PAPER, "creep", strength=0.012), "backlash", play=2.1e-7)
    said = sentence(EFFECTS, ["creep", "backlash"], GAP, PAPER, model, [], [], SCALES)
    assert "1.2 %" in said
    assert ". Besides, there is play between actuator and finger: 210 nm." in said
    assert "Adding creep and backlash takes" in said


def test_effects_that_cannot_be_told_apart_are_given_as_either_or() -> None:
    model = with_effect(PAPER, "amplifier_lag", lag=2e-3, curvature=0.0)
    rival = candidate("sensor_lag", 18e-9, averaging=0.0, time_constant=2.1e-3)
    group = ("amplifier_lag", "sensor_lag")
    said = sentence(EFFECTS, ["amplifier_lag"], GAP, PAPER, model, [rival], [], SCALES, [group])
    assert said.startswith("Either the amplifier lags: it follows a ramp of the voltage 2.0 ms")
    assert "or the sensor lags: it has a time constant of 2.1 ms (first order); these rec" in said
    assert "Adding amplifier lag or sensor lag takes" in said


@pytest.mark.parametrize(("low", "vague"), [(9.8e-3, False), (5.2e-3, True)])
def test_a_value_that_the_recordings_leave_open_is_told_with_its_interval(
    low: float, vague: bool
) -> None:
    rig = with_effect(PAPER, "transport_delay", delay=9.9e-3)
    interval = Setting(9.9e-3, interval=(low, 1e-2))
    values = {**rig.settings["transport_delay"], "delay": interval}
    rig = replace(rig, settings={**rig.settings, "transport_delay": values})
    text = sentence(EFFECTS, ["transport_delay"], GAP, PAPER, rig, [], [], SCALES)
    assert ("a delay of 9.9 ms (5.2 ms to 10 ms would do as well)." in text) == vague
    assert ("a delay of 9.9 ms." in text) != vague


def test_what_belongs_to_each_recording_is_told_with_its_size() -> None:
    model = with_effect(PAPER, "mains_hum", frequency=50.0)
    hum = candidate("mains_hum", 30e-9)
    sizes = {"mains_hum": 35e-9}
    said = sentence(EFFECTS, ["mains_hum"], GAP, PAPER, model, [hum], [], SCALES, sizes=sizes)
    assert "at 50.0 Hz (35 nm rms)" in said


def test_no_gap() -> None:
    gap = Gap(15.2e-9, 15.1e-9, 15.2e-9, 15e-9, 0.0, 0.0, 0.0, 0.0, True)
    said = sentence(NONE, [], gap, PAPER, PAPER, [], [], SCALES)
    assert said == (
        "The model explains the recordings down to their noise: "
        "it leaves 15 nm (noise floor 15 nm)."
    )


def test_a_model_that_nothing_beats_is_not_said_to_explain_everything() -> None:
    gap = Gap(680e-9, 683e-9, 680e-9, 240e-9, 0.0, 0.0, 0.0, 0.0, True)
    said = sentence(NONE, [], gap, PAPER, PAPER, [], [], SCALES)
    assert said == (
        "Nothing that was tried foretells the recordings better than the model: "
        "it leaves 680 nm (noise floor 240 nm)."
    )


def test_parameters_that_moved_are_named_and_undetermined_ones_are_not() -> None:
    d, m = PAPER.value("bouc_wen", "d"), PAPER.value("second_order", "m")
    changes = {
        ("bouc_wen", "d"): Setting(1.091 * d, (1.08 * d, 1.10 * d)),
        ("bouc_wen", "alpha"): Setting(0.0705, (0.070, 0.071)),
        ("second_order", "m"): Setting(3.0 * m, (0.1 * m, 9.0 * m)),
    }
    refit = PAPER.with_settings(changes)
    said = sentence(PARAMETERS, [], GAP, PAPER, refit, [], [], SCALES)
    assert "alpha by -12 %, d by +9.1 %." in said
    assert "from 90 nm to 17 nm" in said


def test_a_parameter_that_was_zero_is_told_first() -> None:
    d = PAPER.value("bouc_wen", "d")
    given = PAPER.with_values({("bouc_wen", "gamma"): 0.0})
    changes = {
        ("bouc_wen", "d"): Setting(1.091 * d, (1.08 * d, 1.10 * d)),
        ("bouc_wen", "gamma"): Setting(-0.0227, (-0.0228, -0.0226)),
    }
    refit = given.with_settings(changes)
    said = sentence(PARAMETERS, [], GAP, given, refit, [], [], SCALES)
    assert "The model's parameters are off, and nothing else: gamma from 0 to -0.023, d by" in said


def test_parameters_of_one_name_are_told_apart() -> None:
    lags = PAPER.with_link("amplifier_lag").with_link("sensor_lag", curvature=0.1)
    changes = {
        ("amplifier_lag", "curvature"): Setting(0.15, (0.14, 0.16)),
        ("sensor_lag", "curvature"): Setting(0.11, (0.105, 0.115)),
    }
    said = sentence(PARAMETERS, [], GAP, lags, lags.with_settings(changes), [], [], SCALES)
    assert "amplifier_lag.curvature by +50 %, sensor_lag.curvature by +10 %." in said


@pytest.mark.parametrize(("share", "expected"), [(0.82, "82 %"), (0.05, "disturbance")])
def test_an_unknown_gap_says_how_large_where_and_whether_the_voltage_makes_it(
    share: float, expected: str
) -> None:
    gap = Gap(90e-9, 69e-9, 69e-9, 15e-9, 0.0, 0.0, 0.0, share, True)
    where = [Range("frequency_Hz", 12.0, 40.0, 0.6)]
    said = sentence(UNKNOWN, [], gap, PAPER, PAPER, [], where, SCALES)
    lies = "60 % of its power lies at frequencies of 12 to 40 Hz."
    assert f"still 69 nm (noise floor 15 nm); {lies}" in said
    assert expected in said


def test_a_gain_that_would_explain_it_is_spoken_of() -> None:
    said = sentence(UNKNOWN, [], GAP, PAPER, PAPER, [], [], SCALES, slow_gain=True)
    assert said.startswith("Something is missing that no known effect explains")
    assert "as if its gain changed slowly: look for a supply that sags" in said
    assert "gain" not in sentence(UNKNOWN, [], GAP, PAPER, PAPER, [], [], SCALES)


def test_what_does_not_follow_from_the_voltage_is_not_placed_on_it() -> None:
    foreign = Gap(90e-9, 69e-9, 69e-9, 15e-9, 0.0, 0.0, 0.0, 0.05, True)
    where = [Range("voltage_V", 100.0, 130.0, 0.9), Range("time_s", 5.0, 9.0, 0.8)]
    said = sentence(UNKNOWN, [], foreign, PAPER, PAPER, [], where, SCALES)
    assert "80 % of its power lies 5.0 to 9.0 s into the recording" in said
    assert "100 to 130 V" in sentence(
        UNKNOWN, [], replace(foreign, free_form=0.8), PAPER, PAPER, [], where, SCALES
    )
    alone = sentence(UNKNOWN, [], foreign, PAPER, PAPER, [], where[:1], SCALES)
    assert "(noise floor 15 nm). Hardly any" in alone


def test_no_disturbance_is_looked_for_where_an_effect_takes_much_away() -> None:
    gap = Gap(90e-9, 69e-9, 69e-9, 15e-9, 0.0, 0.0, 0.0, 0.05, False, "friction", 0.5)
    said = sentence(UNKNOWN, [], gap, PAPER, PAPER, [], [], SCALES)
    assert said.endswith(
        "Added alone, friction takes 50 % of it away, so as much follows from the voltage, at "
        "least."
    )
    better = sentence(UNKNOWN, [], replace(gap, free_form=0.7), PAPER, PAPER, [], [], SCALES)
    assert "A free-form model closes 70 % of it" in better


def test_of_what_shows_once_nobody_knows_whether_the_voltage_makes_it() -> None:
    gap = Gap(90e-9, 69e-9, 69e-9, 15e-9, 0.0, 0.0, 0.0, 0.05, False, unseen=True)
    said = sentence(UNKNOWN, [], gap, PAPER, PAPER, [], [], SCALES)
    assert "disturbance" not in said
    assert "Whether it follows from the voltage cannot be told" in said


def test_only_what_knows_the_voltage_alone_tells_what_follows_from_it() -> None:
    shares = {"thermal_drift": 0.9, "creep": 0.8, "sensor_quantization": 0.7, "friction": 0.4}
    found = [
        replace(candidate(name, 30e-9), share=share)
        for name, share in {**shares, "contact": 0.3}.items()
    ]
    driver = most_driven([*found, Candidate(UNKNOWN, None, 0.5, 0.5, None)])
    assert driver is not None
    assert driver.effect == "friction"
    assert most_driven([replace(one, share=0.0) for one in found]) is None
