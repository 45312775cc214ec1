"""The whole rig, marched in time: voltage in, displacement out, one call after the other.

The internal grid is a whole number of steps a sample and at least 100 kHz. A voltage that jumps at
the samples is held exactly; one that runs on between them is straight over a step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.validation.base import Base, Scale
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.drive import KNOTS, Drive
from microgripper_control.validation.effects.form import (
    Element,
    Force,
    Form,
    Slot,
    Surroundings,
)
from microgripper_control.validation.hysteresis import march_hysteresis
from microgripper_control.validation.oscillator import Oscillator

SLOWEST_GRID = 100e3  # Hz


def steps_a_sample(sample_period: float, rate: float = SLOWEST_GRID) -> int:
    """Internal steps in a sample, for a grid of at least `rate` Hz and all knots on it."""
    return KNOTS * max(2, math.ceil(rate * sample_period / KNOTS - 1e-9))


@dataclass(frozen=True)
class Applied:
    """A form with its numbers; `label` tells the chance of one effect from that of another."""

    effect: str
    form: Form
    strength: float
    shape: dict[str, float]

    @property
    def label(self) -> list[int]:
        """Numbers made of the effect's name."""
        return list(self.effect.encode())


@dataclass(frozen=True)
class Rig:
    """A base with effects; `scale` is the nominal one whatever the base."""

    base: Base
    scale: Scale
    effects: tuple[Applied, ...] = ()


class Machine:
    """A rig at work in one recording; it begins at rest, unpoled by any past, at 0 V."""

    def __init__(self, rig: Rig, drive: Drive, steps: int, chance: Sequence[int]) -> None:
        self._steps = steps
        self._period = drive.sample_period
        self._step = drive.sample_period / steps
        self._elements: dict[Slot, list[Element]] = {slot: [] for slot in Slot}
        self._hysteresis = np.array(rig.base.hysteresis)
        self._state = np.zeros(2)
        self._slant = 0.0 if drive.knots is None else 1.0
        forces = []
        for applied in sorted(rig.effects, key=lambda one: one.effect):
            if applied.strength == 0.0:
                continue
            seed = np.random.SeedSequence([*chance, *applied.label])
            around = Surroundings(
                rig.scale, self._period, self._step, drive.past, drive.duration, seed
            )
            made = applied.form.build(applied.strength, applied.shape, around)
            if isinstance(made, Force):
                forces.append((made.kind, made.numbers))
            else:
                self._elements[made.slot].append(made)
        self._mechanics = Oscillator(rig.base, forces, self._step, rig.scale.stroke)

    def advance(self, voltage: Array, time: float) -> Array:
        """March over whole samples from `time` on; return the position at the end of each, m."""
        command = voltage.copy()
        slant = np.full(len(command), self._slant)
        block = Block(time, self._step, command, command, slant)
        self._change(Slot.VOLTAGE, block)
        block.signal = np.empty_like(command)
        march_hysteresis(self._hysteresis, self._state, command, block.signal)
        self._change(Slot.FREE, block)
        self._mechanics.run(block.signal, slant)
        self._change(Slot.POSITION, block)
        ends: Array = block.signal[self._steps - 1 :: self._steps].copy()
        return ends

    def read(self, positions: Array, time: float) -> Array:
        """Return the sensor's readings without noise, one a sample; `time` is one sample before."""
        block = Block(time, self._period, positions.copy(), positions, np.ones(len(positions)))
        self._change(Slot.READING, block)
        return block.signal

    def convert(self, readings: Array, time: float) -> Array:
        """Return what is recorded of noisy readings."""
        block = Block(time, self._period, readings.copy(), readings, np.ones(len(readings)))
        self._change(Slot.CONVERTER, block)
        return block.signal

    def shift_hysteresis(self, by: float) -> None:
        """Change h by so many metres, here and now."""
        self._state[0] += by

    @property
    def converts(self) -> bool:
        """Whether the noise changes what the converter makes of a reading."""
        return bool(self._elements[Slot.CONVERTER])

    def _change(self, slot: Slot, block: Block) -> None:
        for element in self._elements[slot]:
            element.run(block)
