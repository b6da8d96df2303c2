"""Every solver against rational arithmetic, whatever the size of the rows: cold, and warm."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lexstack.hqp import (
    DaqpCascade,
    Hierarchy,
    HqpProblem,
    ProxqpCascade,
    make_solver,
)
from lexstack.hqp.columns import column_powers
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from lexstack_experiments.solvers import QuadprogCascade
from support.exact import exact_optimum, exact_slacks
from support.integers import SCALES, integer_problem, shape

# Relative to the largest number of the exact answer, or to 1.
CLOSE = 1e-8
SOLVERS = {
    "kernel": make_solver("kernel"),
    "daqp": make_solver("daqp"),
    "proxqp": make_solver("proxqp"),
    "quadprog": make_solver("quadprog"),
    "daqp, every level": DaqpCascade(guesses=False),
    "quadprog, every level": QuadprogCascade(guesses=False),
}
SEEDS = st.integers(0, 2**32 - 1)


class Exact:
    """The exact answer to a problem, worked out once for all solvers: it takes longer than they."""

    def __init__(self, problem):
        chi = exact_optimum(problem)
        self.chi = np.array([float(x) for x in chi])
        self.size = max(1.0, float(np.abs(self.chi).max(initial=0.0)))
        self.slacks = exact_slacks(problem, chi)
        self.norms = [
            np.linalg.norm(np.vstack([task.matrix for task in level])) for level in problem.levels
        ]

    def is_met_by(self, solution, name):
        """Assert that a solution is the exact one."""
        assert solution.solved, (name, solution.reason)
        near = CLOSE * self.size
        np.testing.assert_allclose(solution.chi, self.chi, atol=near, rtol=0.0, err_msg=name)
        for k, (slack, least, norm) in enumerate(
            zip(solution.slacks, self.slacks, self.norms, strict=True)
        ):
            assert slack <= least + near * norm, (name, k, slack, least)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS, other=SEEDS)
@example(seed=262, other=0)  # a large row gives way by 4e-9, which decides whether a joint is held
@pytest.mark.parametrize("scales", SCALES)
def test_cold_and_warm_answers_are_the_exact_ones_at_any_scale(scales, seed, other):
    rng = np.random.default_rng(seed)
    n, sizes = shape(rng)
    whole = integer_problem(rng, scales, n, sizes)
    before = integer_problem(np.random.default_rng(other), scales, n, sizes)
    exact = Exact(whole)
    for name, solver in SOLVERS.items():
        exact.is_met_by(solver.solve(whole), name)
        exact.is_met_by(solver.solve(whole, solver.solve(before)), f"{name}, warm")


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS)
@pytest.mark.parametrize("scales", SCALES)
def test_inequality_rows_of_any_size_that_cannot_all_hold(scales, seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    whole = integer_problem(rng, scales, n, [n + 2, n + 1], soft=1.0)
    exact = Exact(whole)
    for name, solver in SOLVERS.items():
        exact.is_met_by(solver.solve(whole), name)


@pytest.mark.parametrize("scales", SCALES)
@pytest.mark.parametrize("seed", range(2))
def test_a_long_train_of_warm_starts_never_leaves_the_exact_answers(seed, scales):
    rng = np.random.default_rng((seed, SCALES.index(scales)))
    n, sizes = shape(rng)
    warm = dict.fromkeys(SOLVERS)
    for _ in range(25):
        whole = integer_problem(rng, scales, n, sizes)
        exact = Exact(whole)
        for name, solver in SOLVERS.items():
            warm[name] = solver.solve(whole, warm[name])
            exact.is_met_by(warm[name], name)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(seed=SEEDS)
@pytest.mark.parametrize("solver", [DaqpCascade(), QuadprogCascade(), ProxqpCascade()])
def test_a_cascade_without_a_second_one_is_exact_or_says_that_it_failed(solver, seed):
    rng = np.random.default_rng(seed)
    whole = integer_problem(rng, "rows", *shape(rng))
    solution = solver.solve(whole)
    if solution.solved:
        Exact(whole).is_met_by(solution, solver.name)
    else:
        assert solver.name.startswith("proxqp"), solution.reason


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS, end=st.sampled_from([1e5, 1e7, 1e10]))
def test_an_active_set_that_names_far_ends_gives_no_chi_of_their_size(seed, end):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    whole = integer_problem(rng, "one", n, [int(m) for m in rng.integers(1, 3, size=2)], soft=0.0)
    wide = replace(whole, bounds=Bounds(np.full(n, -end), np.full(n, end)))
    solver = DaqpCascade()
    cold = solver.solve(wide)
    named = replace(cold, active=rng.integers(-1, 2, size=n).astype(np.int8))
    exact = Exact(wide)
    exact.is_met_by(cold, "cold")
    exact.is_met_by(solver.solve(wide, named), "warm")


def with_units(problem, powers):
    """Return a problem whose variable j is given in units that are 2^powers[j] times as large."""
    levels = tuple(
        tuple(
            LinearTask(task.name, np.ldexp(task.matrix, powers), task.lower, task.upper)
            for task in level
        )
        for level in problem.levels
    )
    ends = (np.ldexp(end, -powers) for end in (problem.bounds.lower, problem.bounds.upper))
    return HqpProblem(levels, Bounds(*ends))


def assert_exact_in_units(exact, solution, powers, name):
    """Each variable is judged in the unit in which all columns are of one size."""
    assert solution.solved, (name, solution.reason)
    chi = np.array([float(x * Fraction(2) ** int(p)) for x, p in zip(exact, powers, strict=True)])
    size = max(1.0, float(np.abs(chi).max()))
    mine = np.ldexp(solution.chi, powers)
    np.testing.assert_allclose(mine, chi, atol=CLOSE * size, rtol=0.0, err_msg=name)


@pytest.mark.parametrize("scales", ["one", "levels", "rows"])
@pytest.mark.parametrize("seed", range(12))
def test_variables_of_any_unit_have_the_exact_answer(scales, seed):
    """Columns of um/s beside m/s: answers were wrong, or failed."""
    rng = np.random.default_rng((seed, SCALES.index(scales), 7))
    n, sizes = shape(rng)
    powers = rng.integers(-20, 21, size=n)
    warm = dict.fromkeys(SOLVERS)
    for _ in range(3):
        whole = with_units(integer_problem(rng, scales, n, sizes), powers)
        exact = exact_optimum(whole)
        for name, solver in SOLVERS.items():
            assert_exact_in_units(exact, solver.solve(whole), powers, name)
            warm[name] = solver.solve(whole, warm[name])
            assert_exact_in_units(exact, warm[name], powers, f"{name}, warm")


def test_ordinary_columns_are_taken_as_they_are():
    rng = np.random.default_rng(3)
    for scales in SCALES:
        whole = integer_problem(rng, scales, *shape(rng))
        assert column_powers(Hierarchy(whole.levels, whole.bounds.lower.size), whole) is None
        nearly = with_units(whole, rng.integers(0, 8, size=whole.bounds.lower.size))
        assert column_powers(Hierarchy(nearly.levels, nearly.bounds.lower.size), nearly) is None
