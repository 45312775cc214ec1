"""A start for the fit that does not depend on how far off the given model is.

With n = 1 equation (3) is homogeneous in h: for given beta and gamma the response is linear in d,
in alpha d and, nearly, in the initial h. A coarse grid over the other two, each point solved by
linear least squares, finds the basin of the best fit; simplex and trust region then only descend.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.identification.nuisance import (
    Conditions,
    Nuisance,
    largest_hysteresis,
    response,
)
from microgripper_control.plant.model import Key, Model

D, ALPHA, BETA, GAMMA = (("bouc_wen", name) for name in ("d", "alpha", "beta", "gamma"))
GRID_KEYS: tuple[Key, ...] = (D, ALPHA, BETA, GAMMA)
# Decay of h over the whole voltage range, above and below h = 0: (beta +- gamma) times the range.
DECAYS = (-1.5, -0.5, 0.5, 1.5, 5.0, 12.0)
PROBE_ALPHA = 0.5
PROBE_HYSTERESIS = 0.1  # of the largest
LARGEST_ALPHA = 0.9


def better_start(
    model: Model,
    recordings: Sequence[Recording],
    conditions: Conditions,
    nuisances: Sequence[Nuisance],
) -> tuple[Model, list[Nuisance]]:
    """The better of the given start and the best point of the grid, with its nuisances."""
    best = model, list(nuisances)
    squares = sum(
        _squares(model, recording, conditions, nuisance)
        for recording, nuisance in zip(recordings, nuisances, strict=True)
    )
    reach = max(float(np.ptp(recording.voltage)) for recording in recordings)
    for above, below in product(DECAYS, DECAYS):
        shape = {BETA: (above + below) / (2.0 * reach), GAMMA: (above - below) / (2.0 * reach)}
        found = _solve(model.with_values(shape), recordings, conditions)
        if found is not None and found[0] < squares:
            squares, best = found[0], (found[1], found[2])
    return best


def _squares(
    model: Model, recording: Recording, conditions: Conditions, nuisance: Nuisance
) -> float:
    error = recording.measured - response(model, recording, conditions, nuisance.initial_hysteresis)
    error = error[conditions.unanswered :]
    error = error - error.mean()
    return float(error @ error)


def _solve(
    model: Model, recordings: Sequence[Recording], conditions: Conditions
) -> tuple[float, Model, list[Nuisance]] | None:
    """Linear least squares for d, alpha d and the initial h at the model's beta and gamma."""
    linear, hysteretic = model.with_values({ALPHA: 0.0}), model.with_values({ALPHA: PROBE_ALPHA})
    unknown = not conditions.knows_initial_hysteresis
    columns = 2 + (len(recordings) if unknown else 0)
    normal, right, total = np.zeros((columns, columns)), np.zeros(columns), 0.0
    probes = []
    for index, recording in enumerate(recordings):
        straight = response(linear, recording, conditions, 0.0)
        bent = response(hysteretic, recording, conditions, 0.0)
        basis = np.zeros((columns, len(recording)))
        basis[0], basis[1] = straight, bent - straight
        if unknown:
            probes.append(PROBE_HYSTERESIS * largest_hysteresis(hysteretic, recording))
            basis[2 + index] = response(hysteretic, recording, conditions, probes[-1]) - bent
        basis = basis[:, conditions.unanswered :]
        basis -= basis.mean(axis=1, keepdims=True)
        measured = recording.measured[conditions.unanswered :]
        measured = measured - measured.mean()
        if not np.all(np.isfinite(basis)):
            return None
        normal += basis @ basis.T
        right += basis @ measured
        total += float(measured @ measured)
    weights, *_ = np.linalg.lstsq(normal, right, rcond=1e-12)
    alpha = PROBE_ALPHA * weights[1] / weights[0] if weights[0] > 0.0 else -1.0
    if not 0.0 < alpha < LARGEST_ALPHA:
        return None
    nuisances = [Nuisance(0.0, float(w * p)) for w, p in zip(weights[2:], probes, strict=True)]
    found = model.with_values({D: model.value(*D) * float(weights[0]), ALPHA: float(alpha)})
    squares = total - float(weights @ right)
    return squares, found, nuisances or [Nuisance() for _ in recordings]
