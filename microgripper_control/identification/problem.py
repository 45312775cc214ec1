"""The least-squares problem: free parameters and nuisances in, residuals and Jacobian out.

A point is a vector z: first the free parameters, each divided by its scale, then the initial h of
each recording where it is unknown. Offsets are linear and are eliminated from every residual.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import (
    Conditions,
    Nuisance,
    largest_hysteresis,
    response,
)
from microgripper_control.plant.model import Key, Model

DIFFERENCE = 1e-5  # step of the finite differences, in units of the scale


@dataclass(frozen=True)
class Problem:
    """Fit the parameters `free` of `model` to `recordings`, each of which has a displacement."""

    model: Model
    recordings: Sequence[Recording]
    conditions: Conditions
    free: tuple[Key, ...]

    @cached_property
    def scales(self) -> Array:
        """What one unit of z means for each free parameter, in the parameter's own unit."""
        sizes = []
        for link, name in self.free:
            declared = registry()[link].parameter(name)
            size = abs(self.model.value(link, name)) or abs(declared.nominal)
            sizes.append(size or declared.high - declared.low)
        return np.array(sizes)

    @cached_property
    def hysteresis_scales(self) -> Array:
        """The same for the initial h of each recording, m; empty if they are known."""
        if self.conditions.knows_initial_hysteresis:
            return np.zeros(0)
        bounds = [largest_hysteresis(self.model, recording) for recording in self.recordings]
        return np.array(bounds) if all(bound > 0.0 for bound in bounds) else np.zeros(0)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of z."""
        declared = [registry()[link].parameter(name) for link, name in self.free]
        count = len(self.hysteresis_scales)
        low = np.array([p.low for p in declared]) / self.scales
        high = np.array([p.high for p in declared]) / self.scales
        return np.append(low, np.full(count, -1.0)), np.append(high, np.full(count, 1.0))

    def point(self, model: Model, nuisances: Sequence[Nuisance]) -> Array:
        """The z of a model and its recordings' nuisances."""
        values = np.array([model.value(*key) for key in self.free]) / self.scales
        if not len(self.hysteresis_scales):
            return values
        initial = np.array([nuisance.initial_hysteresis for nuisance in nuisances])
        return np.append(values, initial / self.hysteresis_scales)

    def model_at(self, z: Array) -> Model:
        """The model at a point."""
        values = {}
        for key, size, scale in zip(self.free, z, self.scales, strict=False):
            declared = registry()[key[0]].parameter(key[1])
            # Rounding in the scaling may carry a value on its bound just past it.
            values[key] = float(min(declared.high, max(declared.low, size * scale)))
        return self.model.with_values(values)

    def initial_hysteresis(self, z: Array, index: int) -> float:
        """h at the first sample of a recording, m."""
        if not len(self.hysteresis_scales):
            return 0.0
        return float(z[len(self.free) + index] * self.hysteresis_scales[index])

    def nuisances(self, z: Array) -> list[Nuisance]:
        """The nuisance values of each recording at a point."""
        model = self.model_at(z)
        found = []
        for index, recording in enumerate(self.recordings):
            h = self.initial_hysteresis(z, index)
            error = self._error(model, recording, h)
            found.append(Nuisance(self._offset(error), h))
        return found

    def residuals(self, z: Array) -> Array:
        """Measured minus predicted of all recordings, m, shape (samples,)."""
        model = self.model_at(z)
        parts = []
        for index, recording in enumerate(self.recordings):
            error = self._error(model, recording, self.initial_hysteresis(z, index))
            parts.append(self._without_offset(error))
        return np.concatenate(parts)

    def jacobian(self, z: Array) -> Array:
        """Derivative of the residuals by z, shape (samples, len(z)), by forward differences."""
        base = self.residuals(z)
        _, high = self.bounds
        columns = np.zeros((len(base), len(z)), order="F")
        for index in range(len(self.free)):
            shifted = z.copy()
            step = DIFFERENCE if z[index] + DIFFERENCE <= high[index] else -DIFFERENCE
            shifted[index] += step
            columns[:, index] = (self.residuals(shifted) - base) / step
        start = 0
        model = self.model_at(z)
        for index, recording in enumerate(self.recordings):
            stop = start + len(recording)
            if len(self.hysteresis_scales):
                h = self.initial_hysteresis(z, index) + DIFFERENCE * self.hysteresis_scales[index]
                moved = self._without_offset(self._error(model, recording, h))
                column = len(self.free) + index
                columns[start:stop, column] = (moved - base[start:stop]) / DIFFERENCE
            start = stop
        return columns

    def _offset(self, error: Array) -> float:
        """The zero that fits best, m; 0 where the model freezes it."""
        if "sensor_zero" in self.model.settings:
            return 0.0
        return float(np.mean(error[self.conditions.unanswered :]))

    def _error(self, model: Model, recording: Recording, h: float) -> Array:
        return recording.measured - response(model, recording, self.conditions, h)

    def _without_offset(self, error: Array) -> Array:
        residual = error - self._offset(error)
        residual[: self.conditions.unanswered] = 0.0
        return residual
