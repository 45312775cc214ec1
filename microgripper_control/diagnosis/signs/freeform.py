"""How much of a gap something deterministic in the input could close, whatever it is.

A regression of the residual on many courses that follow from the voltage and from the nominal
prediction: powers, bends, their past over windows from a sample to a third of the recording, play
operators of several widths, rates. It names nothing, knows no law, and is judged on samples that it
never saw; what it cannot close is noise, or no function of the input.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import REAL, Residual, gap_power
from microgripper_control.diagnosis.signs.features import LONGEST_WINDOW, Frame, features
from microgripper_control.identification.nuisance import Mask

MOST_ROWS = 12000  # samples that a fit looks at
RIDGES = (1e-6, 1e-4, 1e-2, 1.0)  # of the mean square of a feature
STRETCHES = 8  # of each recording
FOLDS = 4  # of stretches that are left out in turn to choose features and ridge
WORTH = 0.01  # of the squares left: what a further group of features takes away at least
FADES = 3  # times in which what began before a recording fades
DAMPING = 2e-3  # of the mean square of the roughest course, in proportion to roughness
MARGIN = 0.005  # of a recording: how near to a judging sample nothing is learnt from


def explainable(fitted: Sequence[Residual], judged: Sequence[Residual], noise: float) -> float:
    """Share of the removable error that a free-form model closes on the judged samples, 0 .. 1.

    `fitted` and `judged` may be the same recordings with masks that have no sample in common;
    `noise` is the noise floor, m. With e(r) = sqrt(max(r^2 - noise^2, 0)), the answer is
    1 - e(after) / e(before). Of recordings that only judge, the samples that do not count are
    learnt from, too: the question is what the input determines, not what carries over from a
    staircase to a sweep. They also give each judged recording's own zero and what fades from before
    it, which no input explains.
    """
    before = gap_power(judged, noise)
    if before <= REAL * noise**2 or not fitted:
        return 0.0
    known = {id(residual.recording) for residual in fitted}
    others = [residual for residual in judged if id(residual.recording) not in known]
    learnt = [*fitted, *(replace(residual, counted=_between(residual)) for residual in others)]
    frame = Frame.around(learnt)
    weights = _fit(learnt, frame)
    left = []
    for residual in judged:
        rest = residual.error.copy()
        if weights is not None:
            rest = rest - np.hstack(features(residual, frame)) @ weights
        left.append(_without_own(residual, rest, frame)[residual.counted])
    after = float(np.mean(np.concatenate(left) ** 2)) - noise**2
    return float(np.clip(1.0 - np.sqrt(max(after, 0.0) / before), 0.0, 1.0))


def _fit(fitted: Sequence[Residual], frame: Frame) -> Array | None:
    """Weights of all features; None where none helps.

    Groups of features are added one by one, each with its ridge, as long as what they leave on
    stretches that were left out goes down: many features that explain little predict badly.
    """
    total = sum(int(np.count_nonzero(residual.counted)) for residual in fitted)
    stride = 1 + total // MOST_ROWS
    rows, targets, folds = [], [], []
    for residual in fitted:
        chosen = np.flatnonzero(residual.counted)[::stride]
        groups = features(residual, frame)
        own = np.linalg.qr(_own(residual, frame)[chosen])[0]
        matrix = np.hstack([group[chosen] for group in groups])
        rows.append(matrix - own @ (own.T @ matrix))
        targets.append(residual.error[chosen] - own @ (own.T @ residual.error[chosen]))
        folds.append(np.arange(len(chosen)) * STRETCHES // max(1, len(chosen)) % FOLDS)
    moments = _Moments.of(np.concatenate(rows), np.concatenate(targets), np.concatenate(folds))
    ends = np.cumsum([group.shape[1] for group in groups])
    members = [
        np.arange(end - group.shape[1], end) for group, end in zip(groups, ends, strict=True)
    ]
    chosen_groups: list[int] = []
    best, ridge = float(np.sum(moments.squares)), 0.0
    while len(chosen_groups) < len(members):
        tried = [
            (*moments.left(np.concatenate([members[g] for g in (*chosen_groups, new)])), new)
            for new in range(len(members))
            if new not in chosen_groups
        ]
        left, with_ridge, new = min(tried)
        if left > (1.0 - WORTH) * best:
            break
        best, ridge = left, with_ridge
        chosen_groups.append(new)
    if not chosen_groups:
        return None
    columns = np.concatenate([members[g] for g in chosen_groups])
    weights = np.zeros(int(ends[-1]))
    weights[columns] = moments.solve(columns, ridge, leave=None)
    return weights


@dataclass(frozen=True)
class _Moments:
    """Normal equations of each fold."""

    grams: Array  # shape (folds, p, p)
    moments: Array  # shape (folds, p)
    squares: Array  # shape (folds,)

    @classmethod
    def of(cls, matrix: Array, target: Array, fold: Array) -> _Moments:
        """Of rows, targets and the number of each row's fold."""
        parts = [(matrix[fold == number], target[fold == number]) for number in range(FOLDS)]
        return cls(
            grams=np.stack([rows.T @ rows for rows, _ in parts]),
            moments=np.stack([rows.T @ values for rows, values in parts]),
            squares=np.array([float(values @ values) for _, values in parts]),
        )

    def solve(self, columns: Array, ridge: float, leave: int | None) -> Array:
        """Weights of some columns, fitted on all folds but one."""
        kept = [number for number in range(FOLDS) if number != leave]
        gram = self.grams[kept][:, columns[:, None], columns].sum(axis=0)
        moment = self.moments[kept][:, columns].sum(axis=0)
        size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
        scaled = gram / np.outer(size, size) + ridge * np.eye(len(columns))
        weights: Array = np.linalg.solve(scaled, moment / size) / size
        return weights

    def left(self, columns: Array) -> tuple[float, float]:
        """The least squares left on the folds that were left out, and the ridge that does it."""
        sums = []
        for ridge in RIDGES:
            left = 0.0
            for number in range(FOLDS):
                weights = self.solve(columns, ridge, number)
                gram = self.grams[number][columns[:, None], columns]
                match = float(weights @ self.moments[number][columns])
                left += float(self.squares[number]) - 2.0 * match + float(weights @ gram @ weights)
            sums.append((left, ridge))
        return min(sums)


def _between(residual: Residual) -> Mask:
    """The samples that do not judge, but for those next to one that does."""
    judging = np.flatnonzero(residual.counted)
    margin = int(MARGIN * len(residual.counted))
    near = np.zeros(len(residual.counted) + 1)
    np.add.at(near, np.maximum(judging - margin, 0), 1.0)
    np.add.at(near, np.minimum(judging + margin + 1, len(residual.counted)), -1.0)
    between: Mask = (np.cumsum(near)[:-1] == 0.0) & residual.recording.explained
    return between


def _own(residual: Residual, frame: Frame) -> Array:
    """What a recording has for itself, shape (n, p): its zero and what began before it."""
    time = residual.period * np.arange(len(residual.error))
    fades = np.geomspace(0.01, LONGEST_WINDOW, FADES) * frame.longest
    return np.stack([np.ones(len(time)), *(np.exp(-time / fade) for fade in fades)], axis=1)


def _without_own(residual: Residual, rest: Array, frame: Frame) -> Array:
    """Without what the recording has for itself, fitted on what does not judge."""
    matrix = _own(residual, frame)
    rows: Mask = ~residual.counted & residual.recording.explained
    if np.count_nonzero(rows) < 10 * matrix.shape[1]:
        return rest
    # Between the samples it is fitted on, what fades must not swing further than it has to.
    own = matrix[rows]
    rough = np.mean(np.gradient(matrix, axis=0) ** 2, axis=0)
    damping = DAMPING * np.count_nonzero(rows) * np.diag(rough / np.max(rough))
    left: Array = rest - matrix @ np.linalg.solve(own.T @ own + damping, own.T @ rest[rows])
    return left
