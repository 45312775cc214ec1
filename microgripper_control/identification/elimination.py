"""The initial h of each recording, eliminated: only the recording's own samples feel it.

With R recordings the Jacobian has R columns, each of them zero but on the rows of one recording.
Worked on whole, its cost would grow with the square of R and more. So the columns that all
recordings share are split, recording by recording, along the one that is the recording's own:

    J' J = [ rest' rest + along' along    along' diag(size) ]      shape (p + R, p + R)
           [ diag(size) along             diag(size^2)      ]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.identification.problem import Problem


@dataclass(frozen=True)
class Split:
    """Columns along another one and across it; of several recordings one after the other."""

    sizes: Array  # shape (R,), the length of each recording's own column
    along: Array  # shape (R, p), the components of the columns along it
    rest: Array  # shape (samples, p), what is left of the columns

    @classmethod
    def of(cls, own: Array, columns: Array) -> Split:
        """One recording's columns, shape (n, p), along its own one, shape (n,)."""
        size = float(np.linalg.norm(own))
        unit = own / size if size > 0.0 else own
        along = unit @ columns
        return cls(np.array([size]), along[None], columns - np.outer(unit, along))

    @classmethod
    def by_recording(cls, problem: Problem, z: Array, columns: Array) -> Split:
        """Columns of shape (samples, p) along the initial h of a problem's recordings at a point.

        Where these are known R is 0, and the columns stay as they are.
        """
        own = problem.own_columns(z)
        if not own:
            return cls(np.zeros(0), np.zeros((0, columns.shape[1])), columns)
        parts = [
            cls.of(column, columns[part]) for column, part in zip(own, problem.parts, strict=True)
        ]
        return cls(*(np.concatenate(arrays) for arrays in zip(*map(_arrays, parts), strict=True)))


def _arrays(split: Split) -> tuple[Array, Array, Array]:
    return split.sizes, split.along, split.rest


def turned_residuals(problem: Problem, z: Array) -> Array:
    """The residuals at a point, m, shape (len(z) + 1,), in axes whose first lies along them."""
    turned = np.zeros(len(z) + 1)
    turned[0] = np.linalg.norm(problem.residuals(z))
    return turned


def turned_jacobian(problem: Problem, z: Array) -> Array:
    """Derivative of the residuals by z in the same axes, shape (len(z) + 1, len(z)).

    Its products with itself and with the residuals, all that least squares ask for, are those of
    the whole Jacobian.
    """
    shared = 1 + len(problem.free)
    columns = np.column_stack([problem.residuals(z), problem.columns(z, range(len(problem.free)))])
    split = Split.by_recording(problem, z, columns)
    whole = np.zeros((len(z) + 1, len(z) + 1))  # residuals, free parameters, initial h
    triangle = _triangle(split.rest)
    whole[: len(triangle), :shared] = triangle
    whole[shared:, :shared] = split.along
    whole[shared:, shared:] = np.diag(split.sizes)
    turned = _triangle(whole)
    return np.asarray(turned[:, 1:] * np.copysign(1.0, turned[0, 0]))


def _triangle(columns: Array) -> Array:
    """R of the QR decomposition of columns (samples, p), shape (min(samples, p), p)."""
    return np.asarray(np.linalg.qr(columns, mode="r"))  # numpy's stub types the default mode alone
