"""A black-box model of what the refit leaves: a Gaussian process on the recent past of the voltage.

The process is approximated by random Fourier features (Rahimi and Recht 2007), its length scale and
noise chosen on every fourth stretch of the training recordings. It shrinks the gap and names
nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.examination.beside.evidence import Begun, Rest, rmse_without
from microgripper_control.examination.beside.sparse import Frame, Signals

LAGS = (0, 1, 2, 5, 12, 30, 80, 200, 500, 1500)  # samples, of the fastest recording
FEATURES = 300
LENGTHS = (0.3, 1.0, 3.0)  # standard deviations of the inputs
RIDGES = (1e-5, 1e-3, 1e-1, 10.0)  # of the mean square of a feature
MOST_ROWS = 8000  # that are fitted
STRETCHES, FOLDS = 16, 4
SEED = 20260101


@dataclass(frozen=True)
class Process:
    """Random features of one length scale, and their weights."""

    directions: Array  # shape (inputs, FEATURES)
    phases: Array
    weights: Array

    def __call__(self, inputs: Array) -> Array:
        """What is to be added to the prediction, m, shape (n,)."""
        said: Array = _features(inputs, self.directions, self.phases) @ self.weights
        return said


def shrink(begun: Begun) -> float:
    """The error on the held-out samples, m."""
    training, judging = begun.training(), begun.judging()
    frame = Frame.around(training)
    lags = begun.evidence.scales.sample_period * np.array(LAGS)
    inputs = [_inputs(rest, frame, lags) for rest in training]
    stride = 1 + sum(len(rest.left) for rest in training) // MOST_ROWS
    chosen = [np.flatnonzero(rest.counted)[::stride] for rest in training]
    rows = np.concatenate([each[index] for each, index in zip(inputs, chosen, strict=True)])
    target = np.concatenate([r.left[index] for r, index in zip(training, chosen, strict=True)])
    middle, size = rows.mean(axis=0), rows.std(axis=0) + 1e-12
    process = _fit((rows - middle) / size, target)
    said = [process((_inputs(rest, frame, lags) - middle) / size) for rest in judging]
    return rmse_without(judging, said)


def _fit(rows: Array, target: Array) -> Process:
    generator = np.random.default_rng(SEED)
    drawn = generator.standard_normal((rows.shape[1], FEATURES))
    phases = generator.uniform(0.0, 2.0 * np.pi, FEATURES)
    fold = np.arange(len(rows)) * STRETCHES // len(rows) % FOLDS
    apart = fold == FOLDS - 1
    best: tuple[float, float, float] | None = None
    for length in LENGTHS:
        matrix = _features(rows, drawn / length, phases)
        for ridge in RIDGES:
            weights = _solve(matrix[~apart], target[~apart], ridge)
            left = float(np.sum((target[apart] - matrix[apart] @ weights) ** 2))
            if best is None or left < best[0]:
                best = left, length, ridge
    assert best is not None
    _, length, ridge = best
    weights = _solve(_features(rows, drawn / length, phases), target, ridge)
    if best[0] > float(np.sum(target[apart] ** 2)):
        weights = np.zeros_like(weights)  # what helps on no other stretch is left out
    return Process(drawn / length, phases, weights)


def _solve(matrix: Array, target: Array, ridge: float) -> Array:
    gram = matrix.T @ matrix
    gram[np.diag_indices_from(gram)] += ridge * float(np.trace(gram)) / len(gram)
    weights: Array = np.linalg.solve(gram, matrix.T @ target)
    return weights


def _features(inputs: Array, directions: Array, phases: Array) -> Array:
    return np.asarray(np.cos(inputs @ directions + phases), dtype=np.float64)


def _inputs(rest: Rest, frame: Frame, lags: Array) -> Array:
    """Voltage and prediction now, and the voltage some time ago, shape (n, inputs)."""
    signals = Signals.of(rest, frame)
    index = np.arange(len(signals.u))
    steps = np.rint(lags / signals.period).astype(int)
    past = [signals.u[np.maximum(index - step, 0)] for step in steps]
    return np.stack([*past, signals.x], axis=1)
