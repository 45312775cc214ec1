"""The least-squares problem: free parameters and nuisances in, residuals and Jacobian out.

A point is a vector z: first the free parameters, each divided by its scale, then the initial h of
each recording where it is unknown. The weights of a recording's courses are linear: they are
eliminated from every residual by projection (variable projection, Golub and Pereyra 1973).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import pairwise, starmap

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.mass_under_forces import rings_on
from microgripper_control.effects.registry import registry
from microgripper_control.identification.confidence import Spread
from microgripper_control.identification.last import Last
from microgripper_control.identification.nuisance import (
    Conditions,
    Mask,
    Nuisance,
    Projection,
    course_weights,
    courses,
    largest_hysteresis,
    middle_reading,
    response,
)
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Key, Model

DIFFERENCE = 1e-5  # step of the finite differences, in units of the scale


@dataclass(frozen=True)
class Problem:
    """Fit the parameters `free` of `model` to `recordings`, each of which has a displacement.

    Of each recording only the samples in `used` count, a mask per recording; None counts all.
    """

    model: Model
    recordings: Sequence[Recording]
    conditions: Conditions
    free: tuple[Key, ...]
    used: Sequence[Mask] | None = None
    limits: Mapping[Key, tuple[float, float]] = field(default_factory=dict)  # within the declared
    # Of each recording what its courses were last; `replace` hands them on to another model.
    projections: dict[int, list[tuple[object, Projection]]] = field(
        default_factory=dict, compare=False, repr=False
    )

    @cached_property
    def masks(self) -> list[Mask]:
        """The samples of each recording that count."""
        masks = [self.conditions.answered(recording) for recording in self.recordings]
        if self.used is not None:
            masks = [mask & used for mask, used in zip(masks, self.used, strict=True)]
        return masks

    @cached_property
    def parts(self) -> list[slice]:
        """Where each recording's samples lie among the residuals."""
        ends = np.cumsum([0, *map(np.count_nonzero, self.masks)]).tolist()
        return list(starmap(slice, pairwise(ends)))

    @cached_property
    def samples(self) -> int:
        """How many samples count."""
        return sum(int(np.count_nonzero(mask)) for mask in self.masks)

    @property
    def eliminated(self) -> list[int]:
        """How many weights of courses of each recording are solved for besides z."""
        return [len(courses(self.model, recording)) for recording in self.recordings]

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
        ranges = [self._range(key) for key in self.free]
        count = len(self.hysteresis_scales)
        low = np.array([low for low, _ in ranges]) / self.scales
        high = np.array([high for _, high in ranges]) / self.scales
        return np.append(low, np.full(count, -1.0)), np.append(high, np.full(count, 1.0))

    def _range(self, key: Key) -> tuple[float, float]:
        declared = registry()[key[0]].parameter(key[1])
        return self.limits.get(key, (declared.low, declared.high))

    def point(self, model: Model, initial_hysteresis: Sequence[float]) -> Array:
        """The z of a model and the h that each recording starts with, m."""
        values = np.array([model.value(*key) for key in self.free]) / self.scales
        if not len(self.hysteresis_scales):
            return values
        return np.append(values, np.array(initial_hysteresis) / self.hysteresis_scales)

    def model_at(self, z: Array) -> Model:
        """The model at a point."""
        values = {}
        for key, size, scale in zip(self.free, z, self.scales, strict=False):
            low, high = self._range(key)
            # Rounding in the scaling may carry a value on its bound just past it.
            values[key] = float(min(high, max(low, size * scale)))
        return self.model.with_values(values)

    def initial_hysteresis(self, z: Array) -> list[float]:
        """h at the first sample of each recording, m."""
        if not len(self.hysteresis_scales):
            return [0.0] * len(self.recordings)
        return [float(h) for h in z[len(self.free) :] * self.hysteresis_scales]

    def nuisances(self, z: Array) -> list[Nuisance]:
        """The nuisance values of each recording at a point."""
        model = self.model_at(z)
        found = []
        for index, h in enumerate(self.initial_hysteresis(z)):
            shapes = courses(model, self.recordings[index])[:, self.masks[index]]
            weights = course_weights(shapes, self._error(model, index, h))
            reading = middle_reading(self.recordings[index], self.masks[index])
            age = self.recordings[index].reading_age
            found.append(Nuisance(h, weights, reading, age))
        return found

    def residuals(self, z: Array) -> Array:
        """Measured minus predicted of all recordings, m, shape (samples,)."""
        return self._residuals.at(z, lambda: np.concatenate(self.split_residuals(z)))

    @cached_property
    def _residuals(self) -> Last[Array]:
        """Kept, for the Jacobian is asked for where they just were."""
        return Last()

    @cached_property
    def spreads(self) -> Last[Spread]:
        """Kept for whoever asks how far the parameters scatter: several do, at the same point."""
        return Last()

    def split_residuals(self, z: Array) -> list[Array]:
        """The same, recording by recording."""
        model = self.model_at(z)
        initial = self.initial_hysteresis(z)
        return [self._residual(model, index, h) for index, h in enumerate(initial)]

    def jacobian(self, z: Array) -> Array:
        """Derivative of the residuals by z, shape (samples, len(z)), by forward differences."""
        return self.columns(z, range(len(z)))

    def columns(self, z: Array, wanted: Sequence[int]) -> Array:
        """The columns `wanted` of the Jacobian, shape (samples, len(wanted))."""
        base = self.residuals(z)
        _, high = self.bounds
        columns = np.zeros((len(base), len(wanted)), order="F")
        for column, index in enumerate(wanted):
            if index >= len(self.free):
                recording = index - len(self.free)
                columns[self.parts[recording], column] = self._by_hysteresis(z, recording)
                continue
            along = partial(self._moved, z, index)
            if self.by_sample(index):
                columns[:, column] = self._over_a_sample(along, z, index)
                continue
            ahead = DIFFERENCE if z[index] + DIFFERENCE <= high[index] else -DIFFERENCE
            columns[:, column] = _slope(along, base, ahead)
        return columns

    @cached_property
    def longest_period(self) -> float:
        """s, the sample period of the recording that is sampled most slowly."""
        return max(recording.sample_period for recording in self.recordings)

    def by_sample(self, index: int) -> bool:
        """Whether the recordings show whole samples only of a free parameter.

        A rig that still rings after a sample shows every part of it.
        """
        link, name = self.free[index]
        rings = rings_on(self.model.values("second_order"), self.longest_period)
        held = self.conditions.hold is Hold.ZERO and not rings
        return held and registry()[link].parameter(name).by_sample

    def _over_a_sample(self, along: Callable[[float], Array], z: Array, index: int) -> Array:
        """The slope over the sample about a point: a rig that rests within it shows none in it."""
        low, high = (bound[index] for bound in self.bounds)
        width = self.longest_period / float(self.scales[index])
        back = min(0.5 * width, float(z[index] - low))
        ahead = min(width - back, float(high - z[index]))
        return np.asarray((along(ahead) - along(-back)) / (ahead + back))

    def _moved(self, z: Array, index: int, step: float) -> Array:
        """The residuals a step away from a point."""
        moved = z.copy()
        moved[index] += step
        return np.concatenate(self.split_residuals(moved))

    def own_columns(self, z: Array) -> list[Array]:
        """Of each recording the derivative of its residuals, shape (n,), by its own initial h.

        An empty list if these are known.
        """
        return [self._by_hysteresis(z, index) for index in range(len(self.hysteresis_scales))]

    def projected(self, z: Array, columns: Array) -> Array:
        """Columns of shape (samples, p) without what the courses at a point could explain."""
        model = self.model_at(z)
        return np.concatenate(
            [self._projection(model, i)(columns[part]) for i, part in enumerate(self.parts)]
        )

    def _by_hysteresis(self, z: Array, index: int) -> Array:
        """The derivative by the initial h of one recording on its own samples, shape (n,)."""
        model, own = self.model_at(z), z[len(self.free) + index]

        def residual(step: float) -> Array:
            return self._residual(model, index, float((own + step) * self.hysteresis_scales[index]))

        return _slope(residual, self.residuals(z)[self.parts[index]], DIFFERENCE)

    def _error(self, model: Model, index: int, h: float) -> Array:
        recording = self.recordings[index]
        error = recording.measured - response(model, recording, self.conditions, h)
        return error[self.masks[index]]

    def _residual(self, model: Model, index: int, h: float) -> Array:
        return self._projection(model, index)(self._error(model, index, h))

    def _projection(self, model: Model, index: int) -> Projection:
        """Kept for two states of the courses: those at a point and those a step away."""
        settings = {n: s for n, s in model.settings.items() if n in self._with_courses}
        kept = self.projections.setdefault(index, [])
        for known, projection in kept:
            if known == settings:
                return projection
        shapes = courses(model, self.recordings[index])[:, self.masks[index]]
        kept[:] = [*kept[-1:], (settings, Projection.off(shapes))]
        return kept[-1][1]

    @cached_property
    def _with_courses(self) -> set[str]:
        moments = np.arange(2.0)
        return {
            name
            for name in self.model.settings
            if len(registry()[name].courses(self.model.values(name), moments))
        }


def _slope(along: Callable[[float], Array], base: Array, ahead: float) -> Array:
    """The derivative of what is `base` at a step of zero: by a step ahead, or one back.

    A law may diverge on one side of a point.
    """
    slope = (along(ahead) - base) / ahead
    if np.all(np.isfinite(slope)):
        return slope
    return np.asarray((along(-ahead) - base) / -ahead)
