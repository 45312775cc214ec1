"""What a model leaves of a recording, and the stretches and courses it is looked at along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.runs import runs
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.identification.nuisance import Heldout, Mask, heldout_prediction
from microgripper_control.plant.model import Model

REAL = 0.05  # of the noise's power: a smaller gap could be an error of the noise itself
RESTS = 0.002  # of the stroke: a turn smaller than this is none
STILL = 1e-3  # of the largest change between two samples: below it the voltage is held


class Turning(NamedTuple):
    """How a motion turns back and forth."""

    direction: Array  # -1, 0 or 1, shape (n,)
    travel: Array  # since the last turn, in strokes, shape (n,)
    turns: int


@dataclass(frozen=True)
class Residual:
    """A recording and what a model leaves of it."""

    recording: Recording
    error: Array  # m, shape (n,), measured minus predicted
    counted: Mask  # shape (n,), the samples that count
    zero: float = 0.0  # m, how much higher the sensor's zero is than on average of the recordings

    @property
    def period(self) -> float:
        """Between two samples, s."""
        return self.recording.sample_period

    @property
    def position(self) -> Array:
        """What the sensor shows, m, shape (n,), with the same zero for all recordings."""
        return self.recording.measured - self.zero

    @property
    def predicted(self) -> Array:
        """What the model says that the sensor shows, m, shape (n,)."""
        return self.recording.measured - self.error

    @property
    def foretold(self) -> Residual:
        """The same as if the sensor had shown what the model says: the way without noise."""
        return replace(self, recording=replace(self.recording, displacement=self.predicted))

    @property
    def moves(self) -> Mask:
        """The samples that came with a change of voltage, shape (n,)."""
        change = np.abs(np.diff(self.recording.voltage, prepend=self.recording.voltage[0]))
        moving: Mask = change > STILL * np.max(change)
        return moving

    @property
    def hold_time(self) -> Array:
        """Time since the voltage last changed, s, shape (n,); NaN where it moves."""
        moves = self.moves
        index = np.arange(len(moves))
        last = np.maximum.accumulate(np.where(moves, index, -1))
        since = (index - last) * self.period
        return np.asarray(np.where((last >= 0) & ~moves, since, np.nan), dtype=np.float64)

    @cached_property
    def turning(self) -> Turning:
        """How the predicted motion turns."""
        predicted = self.predicted
        stroke = float(np.ptp(predicted)) or 1.0
        direction, travel = np.zeros(len(predicted)), np.zeros(len(predicted))
        extreme, turned, way, turns = float(predicted[0]), float(predicted[0]), 0.0, 0
        for k, x in enumerate(predicted.tolist()):
            if way == 0.0:
                if abs(x - turned) > RESTS * stroke:
                    way, extreme = float(np.sign(x - turned)), x
            elif (x - extreme) * way >= 0.0:
                extreme = x
            elif (extreme - x) * way > RESTS * stroke:
                way, turned, extreme, turns = -way, extreme, x, turns + 1
            direction[k], travel[k] = way, abs(x - turned) / stroke
        return Turning(direction, travel, turns)

    def means(self, size: int) -> Array:
        """Of each row of `size` samples the mean error of those whose reading counts, m.

        NaN where there is none.
        """
        rows = len(self.error) // size
        counts = self.recording.counting[: rows * size].reshape(rows, size)
        error = np.where(counts, self.error[: rows * size].reshape(rows, size), 0.0)
        known = counts.sum(axis=1)
        return np.where(known > 0, error.sum(axis=1) / np.maximum(known, 1), np.nan)

    def runs(self, shortest: int) -> list[slice]:
        """The stretches of counted samples without a gap, of at least `shortest` samples."""
        return runs(self.counted, shortest)

    def holds(self, shortest: float) -> list[slice]:
        """The stretches, counted or not, in which the voltage is held for `shortest` s or more.

        Each begins with the first sample after the last change, which is one before the stretch.
        """
        edges = [*np.flatnonzero(self.moves).tolist(), len(self.moves)]
        least = max(2, round(shortest / self.period))
        return [slice(a + 1, b) for a, b in pairwise(edges) if b - a > least]


def gap_power(residuals: Sequence[Residual], noise: float) -> float:
    """Mean square of the counted errors above the noise, m^2; `noise` in m."""
    counted = sum(int(np.count_nonzero(residual.counted)) for residual in residuals)
    return gap_energy(residuals, noise) / counted


def gap_energy(residuals: Sequence[Residual], noise: float) -> float:
    """The same summed over the samples, m^2."""
    return sum(float(np.sum(r.error[r.counted] ** 2 - noise**2)) for r in residuals)


class Residuals(NamedTuple):
    """What a model leaves of all recordings."""

    fitted: list[Residual]
    judging: list[Residual]
    zero: float  # m, that of the sensor, on average of the recordings

    @property
    def each_once(self) -> list[Residual]:
        """One of each recording, where samples count that are fitted or judge."""
        found: dict[int, Residual] = {}
        for one in (*self.judging, *self.fitted):
            known = found.get(id(one.recording), one)
            found[id(one.recording)] = replace(known, counted=known.counted | one.counted)
        return list(found.values())


def residuals_of(evidence: Evidence, model: Model) -> Residuals:
    """What a model leaves where it was fitted and where it is judged."""
    recordings = [*evidence.fitted, *evidence.judged]
    said = [*_of_the_fitted(evidence, model), *evidence.predictions(model)]
    usual = _usual(said)
    left, count = _left(recordings, said, usual), len(evidence.fitted)
    return Residuals(left[:count], left[count:], usual)


def fitted_residuals(evidence: Evidence, model: Model) -> list[Residual]:
    """What a model leaves where it was fitted."""
    said = _of_the_fitted(evidence, model)
    return _left(evidence.fitted, said, _usual(said))


def _of_the_fitted(evidence: Evidence, model: Model) -> list[Heldout]:
    """What a model says of each fitted recording; the fitted samples count."""
    said = [heldout_prediction(model, r, evidence.conditions) for r in evidence.fitted]
    return [
        one._replace(counted=used & evidence.conditions.answered(r))
        for r, one, used in zip(evidence.fitted, said, evidence.used, strict=True)
    ]


def _left(recordings: Sequence[Recording], said: Sequence[Heldout], usual: float) -> list[Residual]:
    return [
        Residual(r, r.measured - one.prediction, one.counted, one.zero - usual)
        for r, one in zip(recordings, said, strict=True)
    ]


def _usual(said: Sequence[Heldout]) -> float:
    return float(np.mean([one.zero for one in said]))
