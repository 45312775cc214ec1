"""How strong an effect is made in a case."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from microgripper_control.validation.effects.registry import form_of
from microgripper_control.validation.laboratory import Laboratory, equipped
from microgripper_control.validation.machine import Applied, steps_a_sample
from microgripper_control.validation.oracle import explain
from microgripper_control.validation.strengths import Found, excess, search

ACCEPTABLE = 0.5  # of the wanted excess over the noise that will do
SEARCH_RATE = 25e3  # Hz, internal grid while a strength is searched for
REFINEMENTS = 5  # trials on the full grid, where closed loops answer the effect
CLOSE_ENOUGH = 0.1  # of the ratio, then


def shape_of(effect: str, form: str, seed: int) -> dict[str, float]:
    """The shape parameters that a seed gives a form."""
    generator = np.random.default_rng([seed, *effect.encode()])
    return {p.name: float(generator.uniform(p.low, p.high)) for p in form_of(effect, form).shape}


def sized(
    effect: str, form: str, target: float, excitation: str, laboratory: Laboratory
) -> tuple[Applied, Found]:
    """The effect at the strength whose ratio, by itself, is `target`.

    Where these recordings cannot show that much, and for poor ones always, it is as strong as on a
    good set of recordings of the same rig: what cannot be seen is then not made monstrous instead.
    """
    bare = Applied(effect, form_of(effect, form), 0.0, shape_of(effect, form, laboratory.seed))
    start, strongest = bare.form.strength.nominal, bare.form.strength.high
    if excitation != "poor":
        rough = search(_ratio(bare, laboratory), start, strongest, target)
        found = _refined(bare, rough.strength, target, laboratory)
        if excess(found.ratio) > ACCEPTABLE * excess(target):
            return replace(bare, strength=found.strength), found
    good = equipped(laboratory.seed, "mixed", like=laboratory)
    chosen = search(_ratio(bare, good), start, strongest, target).strength
    ratio = ratio_of(replace(bare, strength=chosen), laboratory)
    found = Found(chosen, ratio, False)
    if ratio > target:
        found = _refined(bare, chosen, target, laboratory)
    return replace(bare, strength=found.strength), found


def ratio_of(applied: Applied, laboratory: Laboratory) -> float:
    """The ratio on the recordings as they are made."""
    steps = steps_a_sample(laboratory.sample_period)
    recordings = laboratory.record([applied], steps)
    scale, noise = laboratory.actuator.scale, laboratory.noise
    return explain(recordings, scale, noise, base=laboratory.base).errors["all"] / noise


def _ratio(bare: Applied, laboratory: Laboratory) -> Callable[[float], float]:
    """The ratio as a function of the strength, over voltages that stay the same."""
    steps = steps_a_sample(laboratory.sample_period, SEARCH_RATE)
    drives = laboratory.drives(steps)
    base = laboratory.base

    def ratio_at(strength: float) -> float:
        nonlocal base
        recordings = laboratory.record([replace(bare, strength=strength)], steps, drives)
        scale, noise = laboratory.actuator.scale, laboratory.noise
        fitted = explain(recordings, scale, noise, base=base)
        base = fitted.rig.base
        return fitted.errors["all"] / noise

    return ratio_at


def _refined(bare: Applied, start: float, target: float, laboratory: Laboratory) -> Found:
    """The strength once more with the ratio on the recordings as they are made."""

    def ratio_at(strength: float) -> float:
        return ratio_of(replace(bare, strength=strength), laboratory)

    strongest = bare.form.strength.high
    return search(ratio_at, start, strongest, target, CLOSE_ENOUGH, REFINEMENTS)
