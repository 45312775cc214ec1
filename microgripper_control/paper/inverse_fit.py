"""Section 6: the inverse model's parameters from displacement to voltage, as Table 2 was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, minimize

from microgripper_control.control.feedforward import Inverse, InverseKind, make_inverse
from microgripper_control.control.identified import Identified
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.material.bouc_wen import LINK

NAMES = ("alpha", "beta", "gamma")
START = (0.1, 0.01, -0.01)  # same order
SIMPLEX_EVALUATIONS = 150
ROOM = 0.5  # of the drive range, on both sides of it: the fit must see how far off a voltage is


@dataclass(frozen=True)
class InverseFit:
    """Parameters fitted from displacement to voltage, with one sensor's recording."""

    sensor: str
    recording: Recording
    values: Mapping[str, float]  # alpha, beta, gamma
    predicted: Array  # V, shape (n - 1,), of the voltages before each displacement but the first
    rmse: float  # V


def with_hysteresis(identified: Identified, values: Mapping[str, float]) -> Identified:
    """The values of a rig with other alpha, beta (1/V) and gamma (1/V)."""
    alpha, beta, gamma = (values[name] for name in NAMES)
    return replace(identified, alpha=alpha, beta=beta, gamma=gamma)


def inverse_voltages(inverse: Inverse, displacement: Array) -> Array:
    """Voltages, V, that an inverse of (3), (4) gives for displacements, m, one a tick, both (n,).

    Voltage k is meant to bring about displacement k at the end of its step.
    """
    result = np.empty(len(displacement))
    for k, wanted in enumerate(displacement):
        result[k] = inverse.step(float(wanted))
        inverse.applied(float(result[k]))
    return result


def fit_inverse(recording: Recording, identified: Identified, sensor: str) -> InverseFit:
    """Fit alpha, beta (1/V), gamma (1/V) of the inverse of (3), (4) to a recording from rest.

    Displacement in, voltage out: simplex, then trust-region reflective least squares on the
    voltage's error, V. The other values are those of `identified`.
    """
    bounds = [(LINK.parameter(name).low, LINK.parameter(name).high) for name in NAMES]
    scales = np.abs(START)
    low, high = (np.array(side) / scales for side in zip(*bounds, strict=True))

    lowest, highest = identified.voltage_range
    room = ROOM * (highest - lowest)
    wide = lowest - room, highest + room

    def predicted(point: Array) -> Array:
        values = dict(zip(NAMES, map(float, np.clip(point, low, high) * scales), strict=True))
        changed = replace(with_hysteresis(identified, values), voltage_range=wide)
        inverse = make_inverse(InverseKind.EXACT, changed, wide, recording.sample_period)
        return inverse_voltages(inverse, recording.measured[1:])

    def error(point: Array) -> Array:
        return predicted(point) - recording.voltage[:-1]

    simplex = minimize(
        lambda point: float(np.mean(error(point) ** 2)),
        np.array(START) / scales,
        method="Nelder-Mead",
        options={"maxfev": SIMPLEX_EVALUATIONS, "xatol": 1e-4, "fatol": 1e-9},
    )
    best = least_squares(
        error, np.clip(simplex.x, low, high), bounds=(low, high), method="trf", x_scale="jac"
    )
    values = dict(zip(NAMES, map(float, best.x * scales), strict=True))
    return InverseFit(
        sensor, recording, values, predicted(best.x), float(np.sqrt(np.mean(best.fun**2)))
    )
