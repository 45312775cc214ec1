"""A start for the fit that does not depend on how far off the given model is.

With n = 1 equation (3) is homogeneous in h: for given beta and gamma the response is linear in d,
in alpha d and, nearly, in the initial h. A coarse grid over the other two, each point solved by
linear least squares, finds the basin of the best fit; simplex and trust region then only descend.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import (
    Conditions,
    Mask,
    Projection,
    courses,
    largest_hysteresis,
    response,
)
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Key, Model

D, ALPHA, BETA, GAMMA = (("bouc_wen", name) for name in ("d", "alpha", "beta", "gamma"))
GRID_KEYS: tuple[Key, ...] = (D, ALPHA, BETA, GAMMA)
# Decay of h over the whole voltage range, above and below h = 0: (beta +- gamma) times the range.
DECAYS = (-1.5, -0.5, 0.5, 1.5, 5.0, 12.0)
PROBE_ALPHA = 0.5
PROBE_HYSTERESIS = 0.1  # of the largest
LARGEST_ALPHA = 0.9
RUN_AWAY = 1e6  # m: h grows without bound where beta + gamma < 0, the faster the more travel


def better_start(problem: Problem, initial: Sequence[float]) -> tuple[Model, list[float]]:
    """The better of the problem's own start and the best point of the grid.

    Returns a model and the h that each recording starts with, m; `initial` holds those of the
    problem's model.
    """
    model = problem.model
    best = model, list(initial)
    residuals = problem.residuals(problem.point(model, initial))
    squares = float(residuals @ residuals)
    regressions = [_Regression.of(problem, index) for index in range(len(problem.recordings))]
    reach = max(float(np.ptp(recording.voltage)) for recording in problem.recordings)
    for above, below in product(DECAYS, DECAYS):
        shape = {BETA: (above + below) / (2.0 * reach), GAMMA: (above - below) / (2.0 * reach)}
        found = _solve(regressions, model.with_values(shape))
        if found is not None and found[0] < squares:
            squares, best = found[0], (found[1], found[2])
    return best


@dataclass(frozen=True)
class _Regression:
    """That of a recording: what beta and gamma do not change of it is made ready once.

    Signals are m, shape (samples that count,).
    """

    recording: Recording
    conditions: Conditions
    mask: Mask
    without: Projection
    linear: Array  # the answer without hysteresis, without what the courses explain,
    measured: Array  # and so what was measured

    @classmethod
    def of(cls, problem: Problem, index: int) -> _Regression:
        """That of one of a problem's recordings."""
        model, recording, mask = problem.model, problem.recordings[index], problem.masks[index]
        without = Projection.off(courses(model, recording)[:, mask])
        straight = model.with_values({ALPHA: 0.0})
        linear = without(response(straight, recording, problem.conditions, 0.0)[mask])
        measured = without(recording.measured[mask])
        return cls(recording, problem.conditions, mask, without, linear, measured)

    def rows(self, model: Model) -> tuple[Array, float] | None:
        """What d and alpha d do, what was measured, and what the initial h does, shape (4, n).

        The initial h is the one returned, m; where it is known its row is zero. None where h runs
        away.
        """
        hysteretic = model.with_values({ALPHA: PROBE_ALPHA})
        bent = self._response(hysteretic, 0.0)
        probe, begun = 0.0, bent
        if not self.conditions.knows_initial_hysteresis:
            probe = PROBE_HYSTERESIS * largest_hysteresis(hysteretic, self.recording)
            begun = self._response(hysteretic, probe)
        if not all(np.all(np.abs(one) < RUN_AWAY) for one in (bent, begun)):
            return None
        bend, own = self.without(bent) - self.linear, self.without(begun - bent)
        return np.stack([self.linear, bend, self.measured, own]), probe

    def _response(self, model: Model, h: float) -> Array:
        return response(model, self.recording, self.conditions, h)[self.mask]


def _solve(
    regressions: Sequence[_Regression], model: Model
) -> tuple[float, Model, list[float]] | None:
    """Linear least squares for d, alpha d and the initial h at the model's beta and gamma.

    A recording's initial h is eliminated from its own normal equations, so that what it costs does
    not grow with the number of recordings.
    """
    normal = np.zeros((3, 3))  # of d, alpha d and what is measured
    shares, probes = [], []  # of each recording's initial h in these
    for regression in regressions:
        found = regression.rows(model)
        if found is None:
            return None
        rows, probe = found
        own = rows @ rows.T
        share = own[3, :3] / own[3, 3] if own[3, 3] > 0.0 else np.zeros(3)
        normal += own[:3, :3] - np.outer(own[3, :3], share)
        shares.append(share)
        probes.append(probe)
    weights, *_ = np.linalg.lstsq(normal[:2, :2], normal[:2, 2], rcond=1e-12)
    alpha = PROBE_ALPHA * weights[1] / weights[0] if weights[0] > 0.0 else -1.0
    d, declared = model.value(*D) * float(weights[0]), registry()[D[0]].parameter(D[1])
    if not 0.0 < alpha < LARGEST_ALPHA or not declared.low <= d <= declared.high:
        return None
    left = np.append(-weights, 1.0)
    initial = [float(share @ left) * probe for share, probe in zip(shares, probes, strict=True)]
    solved = model.with_values({D: d, ALPHA: float(alpha)})
    return float(normal[2, 2] - weights @ normal[:2, 2]), solved, initial
