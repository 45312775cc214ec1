"""Which cases an examination has: four questions, decided by one seed.

Blind: each effect of the library at each strength in both forms, and rigs without any effect.
Withheld: the candidate of the effect at work is taken out of the library. Never: effects that no
library has. Pairs: two at once. The cases are shuffled, so that a case's number tells nothing.
"""

from __future__ import annotations

import enum
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from microgripper_control.validation.effects.registry import in_library, known_effects
from microgripper_control.validation.excitation import EXCITATIONS, suited
from microgripper_control.validation.strengths import RATIOS

BLIND, WITHHELD, NEVER, PAIRS = "blind", "withheld", "never", "pairs"
NONE, PARAMETERS = "none", "parameters"
STRENGTHS = tuple(RATIOS)
VISIBLE = ("medium", "strong")  # where a gap is well above the noise
FORMS = ("a", "b")
POOR, USUAL = "poor", "mixed"
USUAL_WEIGHT = 4.0  # over that of each other excitation

FIRST_SEED = 200_000  # of a case; those below 100 000 are for development
SEEDS_EACH = 10_000  # cases' seeds that each seed of an examination has for itself
MOST = 200_000  # the largest seed of an examination
USED = range(1, 45)  # seeds that were reported once and learned from since: docs/examinations.md

REPEATS = 2  # of each effect, strength and form, in full
BLANKS = 75  # of each of none and parameters, in full
FOREIGN_REPEATS = 2
TOGETHER = 24  # pairs, in full
QUICK_BLANKS, QUICK_WITHHELD, QUICK_NEVER, QUICK_PAIRS = 4, 6, 6, 3


class Part(str, enum.Enum):
    """What may be asked by itself, in the order of the plan."""

    EFFECTS = "effects"  # one effect of the library at a time
    BLANKS = "blanks"  # none and parameters
    WITHHELD = WITHHELD
    NEVER = NEVER
    PAIRS = PAIRS


@dataclass(frozen=True)
class Planned:
    """One case to be made; `excitation` is one of EXCITATIONS."""

    number: int
    question: str
    effects: tuple[str, ...]
    form: str
    strength: str
    excitation: str
    seed: int
    brief: bool = False  # with fewer samples

    @property
    def name(self) -> str:
        """What its files are called, which tells nothing."""
        return f"case_{self.number:03d}"

    @property
    def withheld(self) -> tuple[str, ...]:
        """Effects that are taken out of the library."""
        return self.effects if self.question == WITHHELD else ()

    @property
    def part(self) -> Part:
        """What of the plan it belongs to."""
        if self.question != BLIND:
            return Part(self.question)
        return Part.BLANKS if self.effects[0] in (NONE, PARAMETERS) else Part.EFFECTS

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self) | {"effects": list(self.effects)}

    @classmethod
    def of(cls, plain: dict[str, Any]) -> Planned:
        """The case that `plain` came from."""
        return cls(**(plain | {"effects": tuple(plain["effects"])}))


@dataclass(frozen=True)
class Extent:
    """Which examination, and how much of it."""

    seed: int
    quick: bool = False
    only: Part | None = None
    first: int | None = None  # so many of these cases, which are shuffled

    @property
    def used(self) -> bool:
        """Whether development has seen its cases."""
        return self.seed in USED

    @property
    def caution(self) -> str:
        """What to know before its result is trusted; empty if nothing."""
        flatters = "were learned from: what comes of them flatters the diagnosis"
        return f"the cases of seed {self.seed} {flatters}" if self.used else ""

    @property
    def command(self) -> str:
        """What repeats it, into a folder DIR."""
        quick = " --quick" if self.quick else ""
        only = "" if self.only is None else f" --only {self.only.value}"
        first = "" if self.first is None else f" --first {self.first}"
        return f"microgripper validate --seed {self.seed}{quick}{only}{first} --out DIR"

    def of(self, planned: Sequence[Planned]) -> list[Planned]:
        """The cases of a plan that are to be done."""
        return [one for one in planned if self.only in (None, one.part)][: self.first]


@dataclass(frozen=True)
class _Wanted:
    question: str
    effects: tuple[str, ...]
    form: str
    strength: str
    poor: bool = False


def plan(seed: int, quick: bool) -> list[Planned]:
    """The cases of an examination, the same ones for the same seed, 0 .. MOST."""
    generator = np.random.default_rng([seed, int(quick)])
    wanted = list(_quick(generator) if quick else _full(generator))
    order = generator.permutation(len(wanted))
    first = FIRST_SEED + SEEDS_EACH * seed
    return [
        Planned(
            number,
            one.question,
            one.effects,
            one.form,
            one.strength,
            POOR if one.poor else _excitation(one.effects, generator),
            first + number,
            brief=quick,
        )
        for number, one in enumerate((wanted[i] for i in order), start=1)
    ]


def _full(generator: np.random.Generator) -> Iterator[_Wanted]:
    for effect in in_library(True):
        for form in FORMS:
            for strength in STRENGTHS:
                for _ in range(REPEATS):
                    yield _Wanted(BLIND, (effect,), form, strength)
            for strength in VISIBLE:
                yield _Wanted(WITHHELD, (effect,), form, strength)
        yield _Wanted(BLIND, (effect,), str(generator.choice(FORMS)), "medium", poor=True)
    for effect in in_library(False):
        for strength in VISIBLE:
            for _ in range(FOREIGN_REPEATS):
                yield _Wanted(NEVER, (effect,), _only_form(effect), strength)
    for blank in (NONE, PARAMETERS):
        for _ in range(BLANKS):
            yield _Wanted(BLIND, (blank,), "a", "medium")
    yield from _pairs(generator, TOGETHER)


def _quick(generator: np.random.Generator) -> Iterator[_Wanted]:
    shuffled = [str(name) for name in generator.permutation(in_library(True))]
    for i, effect in enumerate(shuffled):
        form, strength = FORMS[i % len(FORMS)], STRENGTHS[i % len(STRENGTHS)]
        yield _Wanted(BLIND, (effect,), form, strength)
    for i, effect in enumerate(generator.permutation(in_library(True))[:QUICK_WITHHELD]):
        form, strength = FORMS[i % 2], VISIBLE[i // 2 % 2]
        yield _Wanted(WITHHELD, (str(effect),), form, strength)
    for i, effect in enumerate(generator.permutation(in_library(False))[:QUICK_NEVER]):
        yield _Wanted(NEVER, (str(effect),), _only_form(str(effect)), VISIBLE[i % 2])
    for blank in (NONE, PARAMETERS):
        for _ in range(QUICK_BLANKS):
            yield _Wanted(BLIND, (blank,), "a", "medium")
    yield from _pairs(generator, QUICK_PAIRS)


def _pairs(generator: np.random.Generator, count: int) -> Iterator[_Wanted]:
    for i in range(count):
        one, other = generator.choice(in_library(True), 2, replace=False)
        yield _Wanted(PAIRS, (str(one), str(other)), FORMS[i % 2], VISIBLE[i // 2 % 2])


def _only_form(effect: str) -> str:
    return known_effects()[effect].forms[0].name


def _excitation(effects: Sequence[str], generator: np.random.Generator) -> str:
    """One on which the effects can be seen, most often some of everything."""
    named = [effect for effect in effects if effect in known_effects()]
    choices = [
        one for one in EXCITATIONS if one != POOR and all(one in suited(name) for name in named)
    ]
    weights = np.array([USUAL_WEIGHT if one == USUAL else 1.0 for one in choices])
    return str(generator.choice(choices, p=weights / weights.sum()))
