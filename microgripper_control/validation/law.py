"""The rig's law as a function of a vector of numbers near one, for refitting it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.validation.base import FITTED, Base, Scale
from microgripper_control.validation.block import Array
from microgripper_control.validation.drive import KNOTS, Drive
from microgripper_control.validation.machine import Applied, Rig
from microgripper_control.validation.simulate import expected

WIDEST = 0.5  # of a base parameter's nominal value, either way
STRENGTH = "strength"


@dataclass(frozen=True)
class Taken:
    """One recording as the rig's maker knows it."""

    name: str
    drive: Drive
    measured: Array  # m
    chance: tuple[int, ...]

    @property
    def time(self) -> Array:
        """Sampling instants, s."""
        instants: Array = self.drive.sample_period * np.arange(float(len(self.measured)))
        return instants

    @property
    def voltage(self) -> Array:
        """As recorded, V."""
        return self.drive.recorded

    @property
    def heldout(self) -> bool:
        """Whether it is kept from the fit."""
        return self.name.startswith("heldout")


class Law:
    """A law as a function of a vector of numbers near one: base factors, then the effects'."""

    def __init__(
        self, scale: Scale, effects: Sequence[Applied], steps: int | None, noise: float
    ) -> None:
        self._scale = scale
        self._start = tuple(effects)
        self._steps = steps
        self._noise = noise
        self._free: list[tuple[int, str, float, float]] = []
        for i, applied in enumerate(effects):
            self._free.append((i, STRENGTH, 0.0, applied.form.strength.high))
            if applied.form.repeatable:
                self._free += [(i, p.name, p.low, p.high) for p in applied.form.shape]

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest vector; the effects' numbers are in units of their ranges."""
        ones, zeros = np.ones(len(FITTED)), np.zeros(len(self._free))
        return (
            np.concatenate([(1.0 - WIDEST) * ones, zeros]),
            np.concatenate([(1.0 + WIDEST) * ones, zeros + 1.0]),
        )

    @property
    def bare(self) -> Law:
        """The base's part of the law, which takes the same vectors."""
        return Law(self._scale, (), None, self._noise) if self._start else self

    def vector(self, base: Base) -> Array:
        """The vector of a base and the starting effects."""
        nominal = self._scale.base
        seen = base.equivalent(nominal)
        values = [getattr(seen, name) / getattr(nominal, name) for name in FITTED]
        for i, name, low, high in self._free:
            applied = self._start[i]
            value = applied.strength if name == STRENGTH else applied.shape[name]
            values.append((value - low) / (high - low))
        inside: Array = np.clip(np.array(values), *self.bounds)
        return inside

    def rig(self, vector: Array) -> Rig:
        """The rig of a vector."""
        factors = {name: float(by) for name, by in zip(FITTED, vector, strict=False)}
        effects = list(self._start)
        for (i, name, low, high), value in zip(self._free, vector[len(FITTED) :], strict=False):
            real = low + float(value) * (high - low)
            if name == STRENGTH:
                effects[i] = replace(effects[i], strength=real)
            else:
                effects[i] = replace(effects[i], shape={**effects[i].shape, name: real})
        return Rig(self._scale.base.scaled(factors), self._scale, tuple(effects))

    def residual(self, vector: Array, taken: Taken, shift: float) -> Array:
        """Prediction less measurement of a vector; see `deviation`."""
        return self.deviation(self.rig(vector), taken, shift)

    def deviation(self, rig: Rig, taken: Taken, shift: float) -> Array:
        """Prediction less measurement, m; its mean, the recording's own offset, is removed.

        `shift` of the initial hysteresis is in hundredths of the stroke.
        """
        steps = self._steps or (1 if taken.drive.knots is None else KNOTS)
        moved = 0.01 * shift * self._scale.stroke
        predicted = expected(rig, taken.drive, steps, taken.chance, self._noise, moved)
        difference: Array = predicted - taken.measured
        difference -= difference.mean()
        return difference
