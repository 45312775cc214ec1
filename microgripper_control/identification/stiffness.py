"""Stiffness of a flexure from forces and the displacements they cause, section 4 of the paper.

    x = x0 + F / k

The force is set and the displacement is measured, so the scatter is in x: x is regressed on F, and
the bounds of the stiffness are the reciprocal bounds of the slope.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.identification.confidence import LEVEL, interval

FEWEST = 3  # points: two lie on a line whatever they mean
SIZES = 1e-50, 1e50  # N, m: squares of more, and quotients by those of less, are no numbers


@dataclass(frozen=True)
class Stiffness:
    """A straight line through force and displacement, and how well it holds."""

    value: float  # k, N/m
    interval: tuple[float, float]  # 95 %, N/m
    offset: float  # x0, m
    rmse: float  # m, of the displacements about the line
    bend: float  # of the best parabola: its largest distance from its chord, share of the stroke
    bend_seen: bool  # whether that bend stands out of the scatter (95 %)
    points: int

    def displacement(self, force: Array) -> Array:
        """The line, m, at forces, N."""
        return self.offset + force / self.value


def fit_stiffness(force: Array, displacement: Array, name: str = "flexure") -> Stiffness:
    """Least-squares line through displacements (m) at forces (N), both of shape (n,), n >= 3.

    Raises MicrogripperError that begins with `name` for too few points, values that are not finite
    or of no size to reckon with (1e-50 to 1e50), a force that never changes, and data that show no
    stiffness: a displacement that does not rise with the force, or rises less than its scatter lets
    one say.
    """
    if len(force) != len(displacement) or len(force) < FEWEST:
        raise MicrogripperError(
            f"{name}: {len(force)} forces and {len(displacement)} displacements; "
            f"at least {FEWEST} pairs are needed"
        )
    if not (np.all(np.isfinite(force)) and np.all(np.isfinite(displacement))):
        raise MicrogripperError(f"{name}: a force or displacement is not finite; remove it")
    _check_size(force, f"{name}: the largest force", "N")
    _check_size(displacement, f"{name}: the largest displacement", "m")
    if np.ptp(force) == 0.0:
        raise MicrogripperError(f"{name}: the force is {force[0]:g} N throughout; vary it")
    offset, slope, variance = _line(force, displacement)
    low, high = interval(slope, variance, len(force) - 2)
    if low <= 0.0:
        raise MicrogripperError(
            f"{name}: displacement per force is {slope:g} m/N, 95 % {low:g} .. {high:g}: "
            "it does not rise with the force; check signs and columns"
        )
    residual = displacement - offset - slope * force
    bend, seen = _bend(force, displacement)
    return Stiffness(
        value=1.0 / slope,
        interval=(1.0 / high, 1.0 / low),
        offset=offset,
        rmse=float(np.sqrt(np.mean(residual**2))),
        bend=bend,
        bend_seen=seen,
        points=len(force),
    )


def _check_size(values: Array, what: str, unit: str) -> None:
    low, high = SIZES
    size = float(np.max(np.abs(values)))
    if size > 0.0 and not low <= size <= high:  # that all are zero has a meaning, told elsewhere
        raise MicrogripperError(
            f"{what} is {size:g} {unit}, outside {low:g} .. {high:g} {unit}; check the unit"
        )


def _line(force: Array, displacement: Array) -> tuple[float, float, float]:
    """Offset, m, slope, m/N, and the slope's variance."""
    centred = force - force.mean()
    power = float(centred @ centred)
    slope = float(centred @ displacement) / power
    offset = float(displacement.mean() - slope * force.mean())
    residual = displacement - offset - slope * force
    return offset, slope, float(residual @ residual) / (len(force) - 2) / power


def _bend(force: Array, displacement: Array) -> tuple[float, bool]:
    """How far a parabola leaves its chord, as a share of the stroke, and whether that is seen."""
    stroke = float(np.ptp(displacement))
    unit = (force - force.min()) / np.ptp(force)
    basis = np.stack([np.ones_like(unit), unit, unit * (1.0 - unit)], axis=1)
    freedom = len(force) - basis.shape[1]
    if freedom < 1 or np.linalg.matrix_rank(basis) < basis.shape[1] or stroke == 0.0:
        return 0.0, False
    weights, *_ = np.linalg.lstsq(basis, displacement, rcond=None)
    residual = displacement - basis @ weights
    variance = float(residual @ residual) / freedom * np.linalg.inv(basis.T @ basis)[2, 2]
    bound = float(stdtrit(freedom, 0.5 + LEVEL / 2.0)) * math.sqrt(variance)
    return float(weights[2]) / 4.0 / stroke, abs(float(weights[2])) > bound
