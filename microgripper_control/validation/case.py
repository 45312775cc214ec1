"""Cases: recordings of a rig whose effect is known here and withheld elsewhere.

Everything is decided by the seed; the package's docstring says which seeds are for what.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.validation.base import MISTUNED, Actuator
from microgripper_control.validation.effects.registry import form_of, known_effects
from microgripper_control.validation.laboratory import equipped
from microgripper_control.validation.law import Taken
from microgripper_control.validation.machine import Rig, steps_a_sample
from microgripper_control.validation.oracle import errors_known, explain
from microgripper_control.validation.sizing import sized
from microgripper_control.validation.strengths import wanted_ratio
from microgripper_control.validation.truth import Truth, causes_of, verdict_of

DEVELOPMENT_SEEDS = range(10_000)
REPORTING_SEEDS = range(100_000, 2**31)
QUESTIONS = ("blind", "withheld", "never", "pairs")
NO_EFFECT = ("none", "parameters")


@dataclass(frozen=True)
class Case:
    """Recordings and what a user knows, and the truth.

    A user knows `actuator` (the nominal numbers), `hold` (how the voltage runs between samples) and
    the recordings, which are held out where their name says so. The rest is the rig's maker's:
    `rig`, `noise` (m), `steps` (of the internal grid, a sample) and `truth`.
    """

    seed: int
    actuator: Actuator
    hold: str
    recordings: tuple[Taken, ...]
    rig: Rig
    noise: float
    steps: int
    truth: Truth


def make_case(
    question: str,
    effects: Sequence[str],
    form: str,
    strength: str,
    excitation: str,
    seed: int,
    brief: bool = False,
) -> Case:
    """Make one case.

    `question` is one of QUESTIONS. `effects` are the causes at work, two for "pairs"; ("none",) is
    the nominal rig itself and ("parameters",) one that is only mistuned. `form` is "a" or "b",
    `strength` "weak", "medium" or "strong", `excitation` one of EXCITATIONS. `brief` recordings
    have fewer samples. MicrogripperError names what does not fit.
    """
    named = tuple(effects)
    _check(question, named, form)
    _check_seed(named, form, seed)
    target = wanted_ratio(strength)
    mistuned = named != ("none",)
    laboratory = equipped(seed, excitation, mistuned, brief=brief)
    causes = () if named[0] in NO_EFFECT else named
    found = [sized(name, form, target, excitation, laboratory) for name in causes]
    rig = laboratory.rig([applied for applied, _ in found])
    steps = steps_a_sample(laboratory.sample_period)
    recordings = laboratory.record(rig.effects, steps)
    scale, noise, nominal = laboratory.actuator.scale, laboratory.noise, laboratory.actuator.base
    without = explain(recordings, scale, noise, base=laboratory.base).errors
    sealed = causes_of(found, laboratory, recordings)
    truth = Truth(
        question=question,
        effects=named,
        form=form,
        strength=strength,
        excitation=excitation,
        seed=seed,
        verdict=verdict_of(mistuned, sealed),
        causes=sealed,
        ratio=without["all"] / noise,
        noise_m=noise,
        errors_m={
            "nominal": explain(recordings, scale, noise, iterations=0).errors,
            "refit": without,
            "oracle": errors_known(recordings, rig, noise, steps),
        },
        base={name: getattr(rig.base, name) for name in MISTUNED},
        mistuning={
            name: getattr(rig.base, name) / getattr(nominal, name) - 1.0 for name in MISTUNED
        },
        zeros_m=dict(zip([one.name for one in recordings], laboratory.zeros, strict=True)),
        kinds={plan.name: plan.kind for plan in laboratory.plans},
        hold=laboratory.hold,
        sample_rate_hz=1.0 / laboratory.sample_period,
    )
    return Case(
        seed, laboratory.actuator, laboratory.hold, tuple(recordings), rig, noise, steps, truth
    )


def _check(question: str, effects: tuple[str, ...], form: str) -> None:
    if question not in QUESTIONS:
        raise MicrogripperError(f"rig: question {question!r}; known are {', '.join(QUESTIONS)}")
    wanted = 2 if question == "pairs" else 1
    if len(set(effects)) != wanted or len(effects) != wanted:
        raise MicrogripperError(f"rig: {question} takes {wanted} effects, not {', '.join(effects)}")
    if effects[0] in NO_EFFECT and question == "blind":
        return
    for effect in effects:
        form_of(effect, form)
        if known_effects()[effect].in_library == (question == "never"):
            raise MicrogripperError(f"rig: {effect} is no effect for the question {question!r}")


def _check_seed(effects: tuple[str, ...], form: str, seed: int) -> None:
    if seed not in DEVELOPMENT_SEEDS and seed not in REPORTING_SEEDS:
        raise MicrogripperError(
            f"rig: seed {seed}; 0 .. {DEVELOPMENT_SEEDS[-1]} are for development, "
            f"{REPORTING_SEEDS[0]} and above for reporting"
        )
    if form == "b" and effects[0] not in NO_EFFECT and seed not in REPORTING_SEEDS:
        raise MicrogripperError(
            f"rig: form b is kept for reporting; seed {seed} is below {REPORTING_SEEDS[0]}"
        )
