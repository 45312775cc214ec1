"""The basis by products of rows against singular values, however nearly the rows depend."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.identification.nuisance import HARDLY_SEEN
from microgripper_control.identification.orthonormal import orthonormal


def rows_of_sizes(*sizes: float) -> tuple[Array, Array]:
    """Rows, shape (12, 4000), with these sizes along their directions; and the directions."""
    random = np.random.default_rng(3)
    turned, _ = np.linalg.qr(random.normal(size=(12, 12)))
    directions, _ = np.linalg.qr(random.normal(size=(4000, len(sizes))))
    return turned[:, : len(sizes)] * sizes @ directions.T, directions.T


@pytest.mark.parametrize("smallest", [1.0, 1e-3, 1.1 * HARDLY_SEEN])
def test_it_is_a_basis_of_all_that_the_rows_show(smallest: float) -> None:
    rows, directions = rows_of_sizes(*np.geomspace(smallest, 1.0, 12))
    basis = orthonormal(rows, HARDLY_SEEN)
    np.testing.assert_allclose(basis @ basis.T, np.eye(12), atol=1e-14)
    left = directions - directions @ basis.T @ basis
    np.testing.assert_allclose(left, 0.0, atol=1e-15 / smallest)


def test_what_they_hardly_show_is_left_out() -> None:
    rows, directions = rows_of_sizes(1.0, 0.01, 0.9 * HARDLY_SEEN, 1e-9)
    basis = orthonormal(rows, HARDLY_SEEN)
    assert basis.shape == (2, 4000)
    np.testing.assert_allclose(np.abs(np.linalg.det(basis @ directions[:2].T)), 1.0, rtol=1e-12)
    np.testing.assert_allclose(basis @ directions[2:].T, 0.0, atol=1e-3)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_of_few_rows_or_none(count: int) -> None:
    rows = np.random.default_rng(4).normal(size=(count, 50))
    basis = orthonormal(rows, HARDLY_SEEN)
    assert basis.shape == (count, 50)
    np.testing.assert_allclose(rows @ basis.T @ basis, rows, atol=1e-14)
