"""Voltages and runs that the tests of the rig share."""

from __future__ import annotations

import numpy as np

from microgripper_control.validation.base import ACTUATORS, Actuator
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.drive import KNOTS, Drive
from microgripper_control.validation.effects.form import Element, Surroundings
from microgripper_control.validation.effects.registry import form_of, known_effects
from microgripper_control.validation.machine import Applied, Rig
from microgripper_control.validation.simulate import measure, run
from microgripper_control.validation.sizing import shape_of

PERIOD = 1e-3
STEPS = 104
STEP = 1e-5  # s, of an element run by itself
PAPER, BIPOLAR, DATASHEET = ACTUATORS
FORMS = [(name, form.name) for name, effect in known_effects().items() for form in effect.forms]


def applied(effect: str, form: str, strength: float, **given: float) -> Applied:
    shape = {**shape_of(effect, form, 3), **given}
    return Applied(effect, form_of(effect, form), strength, shape)


def element(effect: str, form: str, strength: float, step: float = STEP, **given: float) -> Element:
    made = applied(effect, form, strength, **given)
    chance = np.random.SeedSequence(5)
    around = Surroundings(PAPER.scale, PERIOD, step, 1.0, 10.0, chance)
    built = made.form.build(strength, made.shape, around)
    assert isinstance(built, Element)
    return built


def answer(made: Element, signal: Array, slant: float = 1.0, step: float = STEP) -> Array:
    """The element's output for a signal that begins at time 0."""
    found = signal.copy()
    made.run(Block(-step, step, found, found, np.full(len(found), slant)))
    return found


def lively(samples: int, actuator: Actuator = PAPER, past: int = 0, smooth: bool = False) -> Drive:
    """Loops over the whole range, a fast ripple, a jump, a hold: something for every effect."""
    fine = KNOTS if smooth else 1
    t = PERIOD / fine * np.arange(samples * fine)
    share = 0.5 - 0.48 * np.cos(2.0 * np.pi * 1.1 * t) + 0.02 * np.sin(2.0 * np.pi * 31.0 * t)
    rest = -actuator.low / (actuator.high - actuator.low)
    share = rest + (share - rest) * np.minimum(t / 0.05, 1.0)
    if not smooth:
        share[t > 0.9 * t[-1]] = 0.3
    voltage = actuator.low + (actuator.high - actuator.low) * share
    return Drive(PERIOD, past, voltage[::fine].copy(), voltage if smooth else None)


def reading(
    rig: Rig, drive: Drive, steps: int = STEPS, noise: float = 0.0, chance: int = 1
) -> Array:
    machine, readings = run(rig, drive, steps, [chance])
    drawn = noise * np.random.default_rng(chance).standard_normal(len(readings))
    return measure(machine, readings, drawn, drive.sample_period)


def rms(signal: Array) -> float:
    return float(np.sqrt(np.mean(signal**2)))
