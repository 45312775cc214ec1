"""What is known before anything is measured: a rig's own parameters are near its model's.

What recordings do not tell, such as how much of a motion is hysteresis where one cycle is repeated,
would otherwise run away with the noise. So the model counts as one more measurement of each of its
parameters, with a standard deviation of a factor of e and the weight of one independent sample:

    row = rms sqrt(tau) ln(p / p0)        beside the residuals; tau is their autocorrelation time

Below p0 the logarithm is replaced by its tangent, for parameters that may be zero or change sign.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.identification.confidence import autocorrelation_time
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Model


class Prior:
    """The rows that a nominal model adds to the residuals of a problem."""

    def __init__(self, nominal: Model, problem: Problem, residual: Array) -> None:
        """Weighed by a `residual`, m, shape (samples,)."""
        values = np.array(
            [nominal.value(*key) if key[0] in nominal.settings else 0.0 for key in problem.free]
        )
        self._known = np.flatnonzero(values)
        self._per_unit = problem.scales[self._known] / values[self._known]  # of z, in units of p0
        rms = float(np.sqrt(np.mean(residual**2)))
        self._weight = rms * np.sqrt(autocorrelation_time(residual))

    def rows(self, z: Array) -> Array:
        """m, one for each parameter that the nominal model has."""
        share = z[self._known] * self._per_unit
        far = np.log(np.maximum(share, 1.0))
        rows: Array = self._weight * np.where(share > 1.0, far, share - 1.0)
        return rows

    def jacobian(self, z: Array) -> Array:
        """Their derivative by z, shape (rows, len(z))."""
        share = z[self._known] * self._per_unit
        slopes = np.zeros((len(self._known), len(z)))
        slopes[np.arange(len(self._known)), self._known] = (
            self._weight * self._per_unit / np.maximum(share, 1.0)
        )
        return slopes
