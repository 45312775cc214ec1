"""How far rival explanations come apart on a voltage that nobody has recorded yet.

Each rival in turn is taken as true, and the others are given what a refit on the new recording
could do for them, linearised: the base parameters, the initial h, the zero, their own courses (a
drift, a hum, creep not yet finished) and the shapes of their effects. The sizes of the effects are
kept: the recording that they all explain asks for them. What is then left is what the experiment
would show. A rival that contains the other one can always imitate it, so there only the richer one
is taken as true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.fits.trial import fitted_keys
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import (
    Conditions,
    Projection,
    courses,
    fit_nuisance,
    largest_hysteresis,
    own_courses,
)
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Key, Model
from microgripper_control.plant.simulate import Initial, simulate

BASE: tuple[Key, ...] = tuple(("bouc_wen", name) for name in ("d", "alpha", "beta", "gamma"))
DIFFERENCE = 1e-3  # of a parameter's size, or of the largest initial h
SETTLING = 0.05  # of the samples: the first ones depend on how it began and do not count


@dataclass(frozen=True)
class Rival:
    """An explanation: what it has beyond the others, and the course of its own it showed."""

    model: Model
    effects: tuple[str, ...]  # those that not all rivals share
    course: Array  # m, shape (samples of the recording,): what its random links did there

    def own_course(self, count: int) -> Array:
        """That course over `count` samples, to and fro if it is shorter, m."""
        if not np.any(self.course):
            return np.zeros(count)
        missing = max(0, count - len(self.course))
        return np.pad(self.course, (0, missing), mode="symmetric")[:count]

    def contains(self, other: Rival) -> bool:
        """Whether it can do all that the other one can."""
        return set(other.effects) <= set(self.effects)


@dataclass(frozen=True)
class Apart:
    """What is left between two rivals if one of them is true."""

    true: int  # its index
    rms: float  # m
    largest: float  # m
    time: float  # s, when it is largest


def rivals_of(
    models: Sequence[Model], recording: Recording, conditions: Conditions
) -> tuple[Rival, ...]:
    """The rivals among fitted models of a recorded rig."""
    shared = set(models[0].effects).intersection(*(model.effects for model in models))
    rivals = []
    for model in models:
        effects = tuple(name for name in model.effects if name not in shared)
        rivals.append(Rival(model, effects, _course(model, effects, recording, conditions)))
    return tuple(rivals)


def _course(
    model: Model, effects: Sequence[str], recording: Recording, conditions: Conditions
) -> Array:
    """What those of some effects that predictions leave out did on the recording, m, shape (n,).

    A drift that all rivals have tells none of them: it would be theirs in any recording.
    """
    own = [name for name in effects if registry()[name].random]
    if not own:
        return np.zeros(len(recording))
    found = own_courses(model, recording, fit_nuisance(model, recording, conditions))
    parts = [weights @ rows for name, (weights, rows) in found.items() if name in own]
    return np.asarray(sum(parts, np.zeros(len(recording))))


@dataclass(frozen=True)
class Rehearsal:
    """The rivals' displacements, m, shape (n,) each, for one voltage of shape (n,)."""

    rivals: tuple[Rival, ...]
    voltage: Array
    sample_period: float
    hold: Hold
    said: tuple[Array, ...]

    @classmethod
    def of(
        cls, rivals: tuple[Rival, ...], voltage: Array, sample_period: float, hold: Hold
    ) -> Rehearsal:
        """Simulate them all, settled at the first voltage when it begins."""
        said = tuple(_driven(rival.model, voltage, sample_period, hold) for rival in rivals)
        return cls(rivals, voltage, sample_period, hold, said)

    def within(self, stroke: float) -> bool:
        """Whether no rival moves further than that, m, or its simulation fails."""
        return all(np.ptp(displacement) <= stroke for displacement in self.said)

    def separations(self) -> dict[tuple[int, int], Apart]:
        """Of each pair (i, j), i < j: what is left of the difference in the harder direction."""
        common = _orthonormal(self._base_columns())
        spans = [
            _orthonormal(self._own_columns(index), common) for index in range(len(self.rivals))
        ]
        found = {}
        for i, one in enumerate(self.rivals):
            for j in range(i + 1, len(self.rivals)):
                ways = [(i, j)] * (not self.rivals[j].contains(one))
                ways += [(j, i)] * (not one.contains(self.rivals[j]))
                left = [self._left(true, wrong, common, spans[wrong]) for true, wrong in ways]
                found[i, j] = min(
                    left, key=lambda apart: apart.rms, default=Apart(i, 0.0, 0.0, 0.0)
                )
        return found

    def _left(self, true: int, wrong: int, common: Array, span: Array) -> Apart:
        course = self.rivals[true].own_course(len(self.voltage))
        difference = (self.said[true] + course - self.said[wrong])[self._first :]
        left = Projection(span)(Projection(common)(difference))
        at = int(np.argmax(np.abs(left)))
        rms = float(np.sqrt(np.mean(left**2)))
        return Apart(true, rms, float(abs(left[at])), (self._first + at) * self.sample_period)

    @property
    def _first(self) -> int:
        """The first sample that counts."""
        return int(SETTLING * len(self.voltage))

    def _run(self, model: Model, hysteresis: float = 0.0) -> Array:
        return _driven(model, self.voltage, self.sample_period, self.hold, hysteresis)

    def _base_columns(self) -> list[Array]:
        """The zero, and what small changes of the plain plant and of its initial h do."""
        model = self.rivals[0].model
        disputed = set(self.rivals[0].effects)
        plain = model.without(
            name for name in model.effects if name in disputed or registry()[name].sampled
        )
        before = self._run(plain)
        changed = [self._run(_moved(plain, key)) - before for key in BASE]
        recording = Recording("rehearsal", self.sample_period, self.voltage)
        changed.append(self._run(plain, DIFFERENCE * largest_hysteresis(plain, recording)) - before)
        return [column[self._first :] for column in (np.ones(len(self.voltage)), *changed)]

    def _own_columns(self, index: int) -> list[Array]:
        """What one rival could give way in besides: its courses and its effects' shapes."""
        rival = self.rivals[index]
        recording = Recording("rehearsal", self.sample_period, self.voltage)
        columns = [*courses(rival.model, recording)]
        columns += [
            self._run(_moved(rival.model, (link, name))) - self.said[index]
            for link, name in fitted_keys(rival.model, rival.effects)
            if registry()[link].parameter(name).vanishing is None
        ]
        return [column[self._first :] for column in columns]


def _driven(
    model: Model, voltage: Array, sample_period: float, hold: Hold, hysteresis: float = 0.0
) -> Array:
    return simulate(
        model,
        voltage,
        sample_period,
        hold=hold,
        initial=Initial.FIRST_SAMPLE,
        initial_hysteresis=hysteresis,
    )


def _moved(model: Model, key: Key) -> Model:
    """The model with one parameter a little changed."""
    parameter = registry()[key[0]].parameter(key[1])
    value = model.value(*key)
    step = DIFFERENCE * (abs(value) or abs(parameter.nominal) or 1e-6 * parameter.high)
    moved = value + step if value + step <= parameter.high else value - step
    return model.with_values({key: moved})


def _orthonormal(columns: Sequence[Array], without: Array | None = None) -> Array:
    """A basis of what the columns span, shape (n, p), beyond what `without` spans."""
    sizes = [float(np.linalg.norm(column)) for column in columns]
    scaled = [c / size for c, size in zip(columns, sizes, strict=True) if 0.0 < size < np.inf]
    block = np.reshape(scaled, (len(scaled), -1)).T if scaled else np.zeros((len(columns[0]), 0))
    if without is not None:
        block = Projection(without)(block)
    basis, size = np.linalg.qr(block)
    kept = np.abs(np.diag(size)) > 1e-9
    orthonormal: Array = basis[:, kept]
    return orthonormal
