"""Where a residual bends: what pushes back beyond a position, or what saturates beyond a level.

After the refit such an effect no longer sits beyond its threshold alone: gain and zero have
followed it half way, and the residual runs along one line below the threshold and along another
above. So the place is looked for in the slope of the residual, in differences over a small travel,
which neither a zero nor anything slow can disturb.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual

TRAVEL = 0.06  # of the range: what the signal moves between two samples that are compared
FAR = 0.3  # of that: pairs that are closer say nothing
LONGEST = 100  # of a recording's samples, one part: the furthest that two of them are apart
PLACES = 45  # thresholds that are tried
EDGE = 0.07  # of the range: no threshold is looked for closer to its ends
EXPLAINED = 0.13  # of the differences' squares that the bend takes away, at least
SHARPER = 1.25  # than a smooth curve with as many weights, at least: ratio of what is left
SHARP = 1.05  # the same, than a smooth curve with one more
AGREEMENT = 0.06  # of the range: how far the places of the two halves may lie apart

FEWEST = 200  # pairs
MOST = 12000  # pairs: more cost time and tell little
REAL = 0.1  # of the noise in the pairs: what they hold beyond it, at least
LEAST = 0.01  # of the squares: what is left below this is as good as nothing

Pick = Callable[[Residual], Array]


@dataclass(frozen=True)
class Onset:
    """A threshold: the residual's slope changes at `place`, more steeply beyond it."""

    place: float  # in the unit of the signal
    low: float  # the range beyond it
    high: float
    slope: float  # m per unit, by how much it changes beyond
    explained: float  # of the differences' squares


class NoOnset(enum.Enum):
    """Why none is told; that the residual has no bend at all, none of them says."""

    STILL = "it changes too little to tell"
    UNSURE = "one half of the samples bends elsewhere than the other"
    SMOOTH = "it may bend, but hardly more sharply than a smooth curve does"


@dataclass(frozen=True)
class _Steps:
    """Differences of residual and signal between pairs of samples."""

    before: Array
    after: Array
    error: Array
    source: Array  # number of the recording

    def half(self, which: int) -> _Steps:
        """Every second piece of them."""
        chosen = np.arange(len(self.error)) * 20 // max(1, len(self.error)) % 2 == which
        return _Steps(
            self.before[chosen], self.after[chosen], self.error[chosen], self.source[chosen]
        )

    def of(self, function: Callable[[Array], Array]) -> Array:
        """Differences of a function of the signal."""
        return function(self.after) - function(self.before)

    def left(self, columns: Sequence[Array]) -> tuple[float, Array]:
        """Squares that a regression on columns leaves, and its coefficients."""
        matrix = np.stack(columns)
        weights = np.linalg.lstsq(matrix @ matrix.T, matrix @ self.error, rcond=1e-10)[0]
        rest = self.error - weights @ matrix
        return float(rest @ rest), weights


def find_onset(residuals: Sequence[Residual], pick: Pick, noise: float) -> Onset | NoOnset:
    """The threshold of a signal, `pick(residual)` of shape (n,), if there is one; `noise` in m.

    Looked for in all recordings together and, if they do not agree, in each by itself.
    """
    best = _find(residuals, pick, noise)
    if isinstance(best, NoOnset) and len(residuals) > 1:
        alone = [_find([residual], pick, noise) for residual in residuals]
        found = [onset for onset in alone if isinstance(onset, Onset)]
        best = max(found, key=lambda onset: onset.explained, default=best)
    if isinstance(best, NoOnset):
        return best
    signals = [pick(residual)[residual.recording.counting] for residual in residuals]
    if best.low == best.place:
        return replace(best, high=max(float(np.max(signal)) for signal in signals))
    return replace(best, low=min(float(np.min(signal)) for signal in signals))


def _find(residuals: Sequence[Residual], pick: Pick, noise: float) -> Onset | NoOnset:
    values = np.concatenate([pick(residual)[residual.counted] for residual in residuals])
    low, high = float(np.min(values)), float(np.max(values))
    if high <= low:
        return NoOnset.STILL
    steps = _differences(residuals, pick, low, high)
    floor = 2.0 * noise**2 * len(steps.error)
    squares = float(steps.error @ steps.error) - floor
    if len(steps.error) < FEWEST or squares < REAL * floor:
        return NoOnset.STILL
    places = np.linspace(low + EDGE * (high - low), high - EDGE * (high - low), PLACES)
    place, left = _best(steps, places)
    line, cubic, quartic = (steps.left(_smooth(steps, degree))[0] - floor for degree in (2, 3, 4))
    explained = (line + floor - left) / squares
    rest = max(left - floor, LEAST * squares)
    if explained < EXPLAINED or cubic < SHARPER * rest or quartic < SHARP * rest:
        return NoOnset.SMOOTH
    halves = [_best(steps.half(which), places)[0] for which in (0, 1)]
    if max(abs(half - place) for half in halves) > AGREEMENT * (high - low):
        return NoOnset.UNSURE
    whole = steps.after - steps.before
    _, (below, change) = steps.left([whole, _hinge(steps, place)])
    beyond = (place, high) if abs(below + change) > abs(below) else (low, place)
    return Onset(place, *beyond, slope=float(change), explained=min(1.0, explained))


def _differences(residuals: Sequence[Residual], pick: Pick, low: float, high: float) -> _Steps:
    before, after, error, source = [], [], [], []
    stride = 1 + sum(len(residual.error) for residual in residuals) // MOST
    for number, residual in enumerate(residuals):
        signal = pick(residual)
        # At a high rate the readings go farther from noise than with the motion.
        speed = float(np.mean(np.abs(np.diff(pick(residual.foretold)))))
        furthest = max(1, len(signal) // LONGEST)
        apart = int(np.clip(TRAVEL * (high - low) / max(speed, 1e-30), 1, furthest))
        for run in residual.runs(apart + 2):
            x, e = signal[run], residual.error[run]
            # Where it rests, the noise of a reading would be compared with itself.
            first = np.arange(0, len(x) - apart, stride)
            first = first[np.abs(x[first + apart] - x[first]) > FAR * TRAVEL * (high - low)]
            before.append(x[first])
            after.append(x[first + apart])
            error.append(e[first + apart] - e[first])
            source.append(np.full(len(error[-1]), float(number)))
    if not error:
        return _Steps(*np.zeros((4, 0)))
    return _Steps(*(np.concatenate(parts) for parts in (before, after, error, source)))


def _best(steps: _Steps, places: Array) -> tuple[float, float]:
    """The place of the bend that leaves least, and the squares it leaves."""
    smooth = _smooth(steps, 2)
    left = [steps.left([*smooth, _hinge(steps, place)])[0] for place in places]
    best = int(np.argmin(left))
    return float(places[best]), left[best]


def _hinge(steps: _Steps, place: float) -> Array:
    return steps.of(lambda x: np.maximum(x - place, 0.0))


def _smooth(steps: _Steps, degree: int) -> list[Array]:
    """Powers of the signal, for each recording by itself: what came before it bends it, too."""
    if len(steps.before) == 0:
        return []
    middle, half = float(np.mean(steps.before)), float(np.ptp(steps.before)) / 2.0 or 1.0
    before, after = (steps.before - middle) / half, (steps.after - middle) / half
    return [
        half * (after**power - before**power) * (steps.source == number)
        for number in np.unique(steps.source)
        for power in range(1, degree + 1)
    ]
