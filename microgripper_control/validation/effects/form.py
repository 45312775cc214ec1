"""What an effect of the rig declares.

Each file in this folder defines `EFFECT`. An effect of the library's list has two forms: "a", which
may be looked at while a method is developed, and "b", which is kept for the final report. An effect
that no library has comes in one form, which is either. A form has one strength, at whose zero it is
gone, and shape parameters that are drawn once a case and that the oracle knows or refits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from microgripper_control.core.parameters import Parameter
from microgripper_control.validation.base import Scale
from microgripper_control.validation.block import Array, Block

STAGES = ("drive", "material", "mechanics", "transmission", "sensor")


class Slot(Enum):
    """Where in the rig an element works, and on which signal."""

    VOLTAGE = "voltage at the stack, V, on the internal grid"
    FREE = "what the stack would move without the flexure, m, on the internal grid"
    POSITION = "displacement, m, on the internal grid"
    READING = "readings before the sensor's noise, m, one a sample"
    CONVERTER = "readings with the sensor's noise, m, one a sample"


@dataclass(frozen=True)
class Element:
    """One thing that a form puts into the rig; `run` changes the block's signal in place.

    One that works on the voltage also keeps the block's slant true.
    """

    slot: Slot
    run: Callable[[Block], None]


@dataclass(frozen=True)
class Force:
    """A force law inside the mechanics' solve: its number in kinds.py and its coefficients."""

    kind: int
    numbers: Array


@dataclass(frozen=True)
class Surroundings:
    """What a form may know when it is built."""

    scale: Scale
    sample_period: float  # s
    step: float  # s, of the internal grid
    past: float  # s before the recording's first sample
    duration: float  # s after it
    chance: np.random.SeedSequence  # of what is random in this recording

    def generator(self) -> np.random.Generator:
        """Random numbers; the same ones at each call."""
        return np.random.default_rng(self.chance)


@dataclass(frozen=True)
class Reach:
    """What the recordings of a case go through."""

    sample_period: float  # s
    voltage: tuple[float, float]  # V
    displacement: tuple[float, float]  # m, before the rig's zero
    rate: float  # V/s, largest
    hold: float  # s, longest time at one level after a step; zero without steps
    duration: float  # s, longest
    scale: Scale


@dataclass(frozen=True)
class Place:
    """Where the effect truly shows: a range on one of the axes of diagnosis.json."""

    axis: str
    low: float
    high: float


Shape = Mapping[str, float]


def nowhere(strength: float, shape: Shape, reach: Reach) -> list[Place]:
    """Of an effect that is spread over everything."""
    return []


@dataclass(frozen=True)
class Form:
    """One functional form; `strength.nominal` is where the search for a wanted strength begins.

    Shape parameters are drawn uniformly from their ranges. `repeatable` is False where a recording
    holds chance that another effect's data do not fix (a drift's course, a hum's phase): as a rival
    on those data the form's oracle would mean nothing.
    """

    name: str
    law: str
    strength: Parameter
    shape: tuple[Parameter, ...]
    build: Callable[[float, Shape, Surroundings], Element | Force]
    where: Callable[[float, Shape, Reach], list[Place]] = nowhere
    repeatable: bool = True

    def __post_init__(self) -> None:
        if self.name not in ("a", "b") or self.strength.vanishing != 0.0:
            raise ValueError(f"form {self.name}: a or b, and a strength that vanishes at 0")


@dataclass(frozen=True)
class Effect:
    """A name, a stage of the signal chain, and the forms."""

    name: str
    stage: str
    in_library: bool
    forms: tuple[Form, ...]

    def __post_init__(self) -> None:
        if self.stage not in STAGES:
            raise ValueError(f"{self.name}: no stage {self.stage}")
        if self.in_library and [form.name for form in self.forms] != ["a", "b"]:
            raise ValueError(f"{self.name}: needs the forms a and b")


def strength(unit: str, start: float, high: float, description: str) -> Parameter:
    """Declare a form's strength: from 0, where it is gone, to the strongest that makes sense."""
    return Parameter("strength", unit, start, 0.0, high, description, vanishing=0.0)


def shape(name: str, unit: str, low: float, high: float, description: str) -> Parameter:
    """Declare a shape parameter by the range it is drawn from."""
    return Parameter(name, unit, 0.5 * (low + high), low, high, description)
