"""The same input gives the same bits, and nothing of an earlier solve is left behind."""

from dataclasses import replace

import numpy as np
import pytest

import lexstack_experiments.solvers  # noqa: F401 - brings quadprog and the oracle
from lexstack.hqp import SOLVERS, make_solver
from lexstack.limits import Bounds
from support.problems import problem

SEQUENCE = [
    problem(kind, seed, 20, 3, inequalities=seed % 3 == 0)
    for seed in range(8)
    for kind in ("nominal", "tight", "infeasible")
]


def run(solver, problems):
    warm, bits = None, []
    for given in problems:
        warm = solver.solve(given, warm)
        bits.append((warm.chi.tobytes(), warm.slacks.tobytes(), warm.active.tobytes()))
    return bits


@pytest.mark.parametrize("name", SOLVERS)
def test_the_same_sequence_gives_the_same_bits(name):
    assert run(make_solver(name), SEQUENCE) == run(make_solver(name), SEQUENCE)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_used_solver_is_as_a_new_one(name):
    used = make_solver(name)
    run(used, SEQUENCE[::-1])
    assert run(used, SEQUENCE) == run(make_solver(name), SEQUENCE)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_solution_is_read_only_and_the_problem_untouched(name):
    given = problem("tight", 1, 12, 3, inequalities=True)
    before = [task.matrix.copy() for level in given.levels for task in level]
    solution = make_solver(name).solve(given)
    for array in (solution.chi, solution.slacks, solution.active):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    after = [task.matrix for level in given.levels for task in level]
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))


@pytest.mark.parametrize("name", SOLVERS)
def test_frozen_input_is_taken(name):
    given = problem("infeasible", 1, 12, 3, inequalities=True)
    for array in (given.bounds.lower, given.bounds.upper):
        array.setflags(write=False)
    for level in given.levels:
        for task in level:
            for array in (task.matrix, task.lower, task.upper):
                array.setflags(write=False)
    assert make_solver(name).solve(given).solved


@pytest.mark.parametrize("name", SOLVERS)
def test_a_warm_start_from_bounds_that_are_gone(name):
    given = problem("infeasible", 1, 12, 3)
    warm = make_solver(name).solve(given)
    assert warm.active.any()
    wide = Bounds(np.full(12, -np.inf), np.full(12, np.inf))
    free = replace(given, bounds=wide)
    solution = make_solver(name).solve(free, warm)
    np.testing.assert_allclose(solution.chi, make_solver(name).solve(free).chi, atol=1e-9)
    other = make_solver(name).solve(problem("tight", 1, 20, 3), warm)
    assert other.solved
