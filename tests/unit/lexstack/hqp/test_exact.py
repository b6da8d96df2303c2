"""The rational solver itself: by its optimality conditions, and by what others find."""

from fractions import Fraction

import numpy as np
import pytest

from lexstack.hqp import HqpProblem
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from lexstack_experiments.solvers import lexicographic_oracle
from support.exact import exact_optimum, exact_slacks
from support.integers import integer_problem, shape


def test_the_answer_is_a_fraction():
    task = LinearTask("row", np.array([[3.0, 0.0]]), np.ones(1), np.ones(1))
    given = HqpProblem(((task,),), Bounds(-np.ones(2), np.ones(2)))
    assert exact_optimum(given) == [Fraction(1, 3), Fraction(0)]
    assert exact_slacks(given, exact_optimum(given)) == [0.0]


@pytest.mark.parametrize("seed", range(40))
def test_its_levels_are_as_good_as_bounded_least_squares(seed):
    rng = np.random.default_rng(seed)
    given = integer_problem(rng, "one", *shape(rng))
    slacks = exact_slacks(given, exact_optimum(given))
    optimum = [level.optimum for level in lexicographic_oracle(given)]
    np.testing.assert_allclose(slacks, optimum, atol=1e-8)


@pytest.mark.parametrize("seed", range(20))
def test_no_step_inside_the_box_makes_the_first_level_smaller(seed):
    rng = np.random.default_rng(seed)
    given = integer_problem(rng, "weights", *shape(rng))
    chi = exact_optimum(given)
    bounds = given.bounds
    assert all(
        low <= x <= high
        for low, x, high in zip(bounds.lower.tolist(), chi, bounds.upper.tolist(), strict=True)
    )
    least = square(given.levels[0], chi)
    for _ in range(40):
        step = [
            Fraction(int(k), 2 ** int(rng.integers(1, 60))) for k in rng.integers(-9, 10, len(chi))
        ]
        near = [
            min(max(x + s, Fraction(low)), Fraction(high))
            for x, s, low, high in zip(
                chi, step, bounds.lower.tolist(), bounds.upper.tolist(), strict=True
            )
        ]
        assert square(given.levels[0], near) >= least


def square(level, chi):
    """Return the exact sum of the squared distances of a level's rows."""
    total = Fraction(0)
    for task in level:
        for row, low, high in zip(
            task.matrix.tolist(), task.lower.tolist(), task.upper.tolist(), strict=True
        ):
            value = sum(Fraction(a) * x for a, x in zip(row, chi, strict=True))
            if value < low:
                total += (Fraction(low) - value) ** 2
            elif value > high:
                total += (value - Fraction(high)) ** 2
    return total
