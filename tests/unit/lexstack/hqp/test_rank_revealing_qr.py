"""The rank-revealing factor against numpy's pseudo-inverse."""

import numpy as np
import pytest

from lexstack.hqp.rank_revealing_qr import factorise

SHAPES = [
    (12, 20, 12),
    (20, 8, 8),
    (6, 6, 6),
    (12, 20, 7),
    (20, 8, 5),
    (5, 5, 3),
    (1, 8, 1),
    (8, 1, 1),
    (60, 40, 40),
    (20, 8, 0),
    (0, 4, 0),
    (4, 0, 0),
]


@pytest.mark.parametrize(("rows", "columns", "rank"), SHAPES)
def test_agrees_with_the_pseudo_inverse(rows, columns, rank):
    rng = np.random.default_rng(rows + columns)
    matrix = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))
    factor = factorise(matrix, 1e-9)
    assert factor.rank == rank

    target = rng.normal(size=rows)
    np.testing.assert_allclose(factor.solve(target), np.linalg.pinv(matrix) @ target, atol=1e-11)
    gradients = rng.normal(size=(3, rows)) @ matrix
    np.testing.assert_allclose(factor.solve_transposed(gradients) @ matrix, gradients, atol=1e-11)
    assert factor.null.shape == (columns, columns - rank)
    np.testing.assert_allclose(matrix @ factor.null, 0.0, atol=1e-12)
    np.testing.assert_allclose(factor.null.T @ factor.null, np.eye(columns - rank), atol=1e-13)


def test_the_tolerance_is_absolute():
    matrix = np.diag([1.0, 1e-3, 1e-6])
    assert factorise(matrix, 1e-9).rank == 3
    assert factorise(matrix, 1e-5).rank == 2
    assert factorise(1e-6 * matrix, 1e-5).rank == 0
