"""What is compiled beside the solver: against numpy."""

import numpy as np
import pytest

from lexstack.hqp.kernel import checks, margins
from lexstack.tasks.kernel import residual
from lexstack.types import LinearTask

RNG = np.random.default_rng(0)


def test_chi_is_put_into_its_box():
    for excess, fits in ((0.0, True), (1e-8, True), (1e-6, False), (np.nan, False)):
        chi, inside = RNG.uniform(-2.0, 2.0, 7), np.empty(7)
        lower, upper = np.minimum(chi, -0.5), np.maximum(chi, 0.5)
        lower[0], upper[1] = -np.inf, np.inf
        given = chi.copy()
        given[2] = upper[2] + excess
        assert checks.clip(given, lower, upper, 1e-7, inside) is fits
        wanted = np.minimum(np.maximum(given, lower), upper)
        np.testing.assert_array_equal(inside[:2], wanted[:2])
        np.testing.assert_array_equal(inside[3:], wanted[3:])
        assert np.isnan(excess) or inside[2] == upper[2]


def test_a_change_of_rows_is_its_frobenius_norm():
    one, other = RNG.normal(size=(6, 9)), np.asfortranarray(RNG.normal(size=(6, 9)))
    change = one - other
    assert margins.squared_change(one, other, 0, 99) == pytest.approx(
        np.vdot(change, change), rel=1e-13
    )
    assert margins.squared_change(one, other[:5], 0, 9) == np.inf
    other[0, 0] = np.nan
    assert np.isnan(margins.squared_change(one, other, 0, 99))


def test_a_joint_stands_beyond_a_margin():
    upper, lower = np.array([1.0, np.inf]), np.array([-1.0, -np.inf])
    for position, beyond in (([1.0, 5.0], False), ([1.1, 0.0], True), ([-1.1, 0.0], True)):
        assert margins.stands(np.array(position), upper, lower) is beyond


def test_a_residual_is_that_of_the_task():
    lower = RNG.normal(size=6)
    upper = lower + np.array([0.0, 0.0, 1.0, 2.0, np.inf, 0.5])
    task, chi = LinearTask("rows", RNG.normal(size=(6, 9)), lower, upper), RNG.normal(size=9)
    rows = task.residual(chi)
    found = residual.square(task.matrix, lower, upper, chi)
    assert found == pytest.approx(float(rows @ rows), rel=1e-13)
    with pytest.raises(ValueError, match="fit"):
        residual.square(task.matrix, lower, upper, chi[:8])


def test_columns_with_an_entry_are_found():
    matrix, moved = RNG.normal(size=(4, 7)), np.empty(7, dtype=bool)
    matrix[:, [1, 5]] = 0.0
    matrix[0, 2], matrix[:3, 6], matrix[3, 6] = -0.0, 0.0, 1e-300
    margins.columns_of(matrix, moved)
    np.testing.assert_array_equal(moved, matrix.any(axis=0))
