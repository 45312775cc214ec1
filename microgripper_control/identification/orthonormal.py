"""An orthonormal basis of what some rows show, by products of whole matrices.

The principal directions of the rows' products are those of the rows; what is smaller than a part of
the largest is left out. Products square sizes, so the smallest directions come out of them
orthonormal to a part in a million only; Cholesky's factorisation of their own products puts that
right, to rounding. Reflections, which go through the rows one by one, take five times as long for
forty of them (for the idea: CholeskyQR2, Yamamoto, Nakatsukasa, Yanagisawa and Fukaya 2015).
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.signals import Array


def orthonormal(rows: Array, least: float) -> Array:
    """A basis, shape (q, n), q <= p, of rows of shape (p, n).

    Directions whose size is no more than `least` of the largest are left out; `least`, beyond
    which their squares drown in rounding, is at least 1e-7.
    """
    squares, directions = np.linalg.eigh(rows @ rows.T)
    seen = squares > least**2 * np.max(squares, initial=0.0)
    basis = (directions[:, seen] / np.sqrt(squares[seen])).T @ rows
    orthonormal_basis: Array = np.linalg.inv(np.linalg.cholesky(basis @ basis.T)) @ basis
    return orthonormal_basis
