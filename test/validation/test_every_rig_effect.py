"""What every form must do: vanish, grow, stay finite, repeat itself, and be its own."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
from rig_runs import DATASHEET, FORMS, PAPER, PERIOD, STEPS, applied, lively, reading, rms

from microgripper_control.validation.base import Actuator
from microgripper_control.validation.drive import Drive
from microgripper_control.validation.effects.form import Effect, Form, strength
from microgripper_control.validation.effects.registry import form_of, in_library, known_effects
from microgripper_control.validation.machine import Machine, Rig

LIBRARY = {
    *("amplifier_lag", "slew_limit", "saturation", "transport_delay"),
    *("creep", "rate_dependent_hysteresis", "asymmetric_hysteresis"),
    *("nonlinear_stiffness", "contact", "friction", "restoring_force_hysteresis"),
    *("backlash", "extra_resonance"),
    *("sensor_lag", "sensor_quantization", "thermal_drift", "mains_hum"),
}
# Strengths, over the usual one, at which events or slow courses show within two seconds.
BOOST = {"sensor_dropouts": 40.0, "slew_limit": 0.3}

each_form = pytest.mark.parametrize(("effect", "form"), FORMS)


def change(
    effect: str, form: str, factor: float, actuator: Actuator = PAPER, smooth: bool = False
) -> np.ndarray:
    """What the effect adds to the readings at a multiple of its usual strength, m."""
    drive = lively(2000, actuator, past=300, smooth=smooth)
    size = factor * BOOST.get(effect, 1.0) * form_of(effect, form).strength.nominal
    bare = Rig(actuator.base, actuator.scale)
    rig = Rig(actuator.base, actuator.scale, (applied(effect, form, size),))
    return reading(rig, drive) - reading(bare, drive)


def test_the_library_s_seventeen_have_both_forms_and_at_least_eight_more_are_foreign() -> None:
    assert set(in_library(True)) == LIBRARY
    assert all((name, form) in FORMS for name in LIBRARY for form in "ab")
    foreign = in_library(False)
    assert len(foreign) >= 8
    assert {known_effects()[name].forms[0].name for name in foreign} == {"a", "b"}


@each_form
@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("actuator", [PAPER, DATASHEET], ids=["paper", "datasheet"])
def test_it_vanishes_continuously_at_zero_strength(
    effect: str, form: str, actuator: Actuator, smooth: bool
) -> None:
    usual = rms(change(effect, form, 1.0, actuator, smooth))
    assert rms(change(effect, form, 1e-5, actuator, smooth)) < max(0.01 * usual, 1e-12)
    assert rms(change(effect, form, 0.0, actuator, smooth)) == 0.0


@each_form
def test_it_grows_with_its_strength(effect: str, form: str) -> None:
    sizes = [rms(change(effect, form, factor)) for factor in (1.0, 1.5, 2.25, 3.4)]
    assert 0.0 < sizes[0] < sizes[-1]
    assert all(more >= less for less, more in pairwise(sizes))


@each_form
@pytest.mark.parametrize("actuator", [PAPER, DATASHEET], ids=["paper", "datasheet"])
def test_it_stays_within_bounds_at_its_strongest(
    effect: str, form: str, actuator: Actuator
) -> None:
    strongest = applied(effect, form, form_of(effect, form).strength.high)
    for smooth in (False, True):
        drive = lively(1500, actuator, smooth=smooth)
        x = reading(Rig(actuator.base, actuator.scale, (strongest,)), drive)
        assert np.isfinite(x).all()
        assert np.abs(x).max() < 10.0 * actuator.scale.stroke


@pytest.mark.parametrize(
    ("effect", "form"), [one for one in FORMS if known_effects()[one[0]].stage == "mechanics"]
)
def test_a_force_lets_the_mass_come_to_rest_however_stiff_it_is(effect: str, form: str) -> None:
    law = form_of(effect, form)
    ramp = np.concatenate([np.linspace(0.0, 155.0, 150), np.full(100, 155.0)])
    for corner in product(*((p.low, p.high) for p in law.shape)):
        given = dict(zip((p.name for p in law.shape), corner, strict=True))
        rig = Rig(PAPER.base, PAPER.scale, (applied(effect, form, law.strength.high, **given),))
        # An odd number of steps a sample shows what alternates from step to step.
        x = reading(rig, Drive(PERIOD, 0, ramp), 101)
        assert np.abs(np.diff(x[-50:], 2)).max() < 1e-11


@each_form
def test_the_same_chance_gives_the_same_numbers(effect: str, form: str) -> None:
    rig = Rig(
        PAPER.base, PAPER.scale, (applied(effect, form, form_of(effect, form).strength.high),)
    )
    drive = lively(1500)
    once, again = reading(rig, drive, noise=1e-8), reading(rig, drive, noise=1e-8)
    assert np.array_equal(once, again)


@each_form
def test_sample_by_sample_gives_the_numbers_of_one_run(effect: str, form: str) -> None:
    size = 3.0 * BOOST.get(effect, 1.0) * form_of(effect, form).strength.nominal
    rig = Rig(PAPER.base, PAPER.scale, (applied(effect, form, size),))
    drive = lively(700, past=100)
    machine = Machine(rig, drive, STEPS, [1])
    found = np.empty(600)
    position = np.zeros(1)
    for j in range(700):
        seen = machine.read(position, drive.instant(j - 1))
        if j >= 100:
            found[j - 100] = machine.convert(seen, drive.instant(j - 1))[0]
        position = machine.advance(drive.internal(j, j + 1, STEPS), drive.instant(j))
    # Times and knots of random courses are the same but for rounding.
    assert found == pytest.approx(reading(rig, drive), rel=1e-9, abs=1e-16)


@pytest.mark.parametrize("effect", sorted(LIBRARY))
def test_the_two_forms_are_not_the_same_signal_at_another_strength(effect: str) -> None:
    first, second = (change(effect, form, 3.0) for form in "ab")
    first, second = first - first.mean(), second - second.mean()
    alike = abs(first @ second) / np.sqrt((first @ first) * (second @ second))
    assert alike < 0.999


@pytest.mark.parametrize("effect", sorted(LIBRARY))
def test_no_two_recordings_share_their_chance(effect: str) -> None:
    for form in known_effects()[effect].forms:
        made = (applied(effect, form.name, form.strength.nominal),)
        drive = Drive(PERIOD, 0, np.zeros(1000))
        rig = Rig(PAPER.base, PAPER.scale, made)
        one, other = (reading(rig, drive, chance=chance) for chance in (1, 2))
        if rms(one) > 0.0 and not form.repeatable and effect != "sensor_quantization":
            assert not np.array_equal(one, other)


def test_a_form_without_a_vanishing_strength_and_an_effect_without_a_stage_are_refused() -> None:
    good = form_of("creep", "a")
    bad = strength("1", 0.5, 1.0, "x")
    object.__setattr__(bad, "vanishing", None)
    with pytest.raises(ValueError, match="vanishes"):
        Form("a", "x", bad, (), good.build)
    with pytest.raises(ValueError, match="no stage"):
        Effect("x", "nowhere", False, (good,))
    with pytest.raises(ValueError, match="forms a and b"):
        Effect("x", "drive", True, (good,))
