"""The exact optimum of one level, from active sets that are right, wrong, or impossible."""

import numpy as np
import pytest

from lexstack.hqp.level_qp import level_qp
from lexstack.hqp.refine import refine


def level(matrix, target, rows, lower, upper):
    matrix, target = np.array(matrix, dtype=float), np.array(target, dtype=float)
    hard = tuple(np.array(x, dtype=float) for x in (rows, lower, upper))
    return level_qp(matrix, np.ones(target.size, dtype=bool), (target, target), hard, norm=1.0)


SIDES = [(a, b, c) for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1)]


@pytest.mark.parametrize("sides", SIDES)
def test_rows_that_contradict_each_other_when_both_are_held(sides):
    # z_0 is wanted at 5; it may go to 1, and, farther out, not beyond 2.
    rows = [[1, 0], [1, 0], [0, 1]]
    qp = level([[1, 0], [0, 1]], [5, 0.3], rows, [-1, -2, -1], [1, 2, 1])
    point = refine(qp, np.array(sides, dtype=np.int8))
    np.testing.assert_allclose(point.z, [1.0, 0.3], atol=1e-12)
    # z_0 is pressed against its bound, z_1 is where the level wants it: nothing is left.
    assert point.null.shape == (2, 0)


@pytest.mark.parametrize("sides", SIDES)
def test_a_row_that_is_touched_and_not_pressed_leaves_its_freedom(sides):
    # The level wants z_0 = 1, which is its bound; z_1 and z_2 are of no interest to it.
    rows = np.eye(3)
    qp = level([[1, 0, 0]], [1], rows, [-1, -1, -1], [1, 1, 1])
    point = refine(qp, np.array(sides, dtype=np.int8))
    assert point.z[0] == pytest.approx(1.0, abs=1e-12)
    assert np.all(np.abs(point.z) <= 1.0 + 1e-12)
    np.testing.assert_allclose(np.abs(point.null.T @ [1.0, 0.0, 0.0]), 0.0, atol=1e-12)
    assert point.null.shape == (3, 2)
