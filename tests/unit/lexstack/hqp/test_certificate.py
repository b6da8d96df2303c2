"""The certificate against the slow oracle: never too good, and tight where chi is optimal."""

import numpy as np
import pytest

from lexstack.hqp import DaqpCascade, HqpProblem
from lexstack_experiments.hierarchies.certificate import certified_excess
from lexstack_experiments.solvers import lexicographic_oracle
from support.problems import KINDS, problem

SOLVER = DaqpCascade()


@pytest.mark.parametrize("inequalities", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_an_optimal_chi_is_certified(kind, inequalities):
    for seed in range(10):
        given = problem(kind, seed, 14, 3, inequalities)
        assert max(certified_excess(given, SOLVER.solve(given).chi)) <= 1e-9


@pytest.mark.parametrize("inequalities", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_the_excess_of_a_chi_that_is_not_optimal_is_not_hidden(kind, inequalities):
    rng = np.random.default_rng(1)
    for seed in range(10):
        given = problem(kind, seed, 14, 1, inequalities)
        lower, upper = given.bounds.lower, given.bounds.upper
        optimum = lexicographic_oracle(given)[0].optimum
        for size in (1e-6, 1e-3, 1.0):
            chi = np.clip(SOLVER.solve(given).chi + size * rng.normal(size=14), lower, upper)
            (task,) = given.levels[0]
            excess = float(np.linalg.norm(task.residual(chi))) - optimum
            assert certified_excess(given, chi)[0] >= excess - 1e-12


def test_a_level_that_a_lower_one_has_spoilt_is_found():
    # The second level solved first: its optimum is reached, the first one's is not.
    found = 0
    for seed in range(10):
        given = problem("infeasible", seed, 14, 2)
        turned = HqpProblem(given.levels[::-1], given.bounds)
        excess = certified_excess(given, SOLVER.solve(turned).chi)
        best = lexicographic_oracle(given)[0].optimum
        (task,) = given.levels[0]
        real = float(np.linalg.norm(task.residual(SOLVER.solve(turned).chi))) - best
        assert excess[0] >= real - 1e-12
        found += excess[0] > 1e-3
    assert found >= 8


def test_the_excess_of_the_second_level_is_that_at_what_the_first_has_reached():
    rng = np.random.default_rng(2)
    for seed in range(10):
        given = problem("nominal", seed, 14, 2)
        solution = SOLVER.solve(given)
        (task,) = given.levels[0]
        null = np.linalg.svd(task.matrix)[2][np.linalg.matrix_rank(task.matrix) :]
        if not len(null):
            continue
        move = 1e-3 * null.T @ rng.normal(size=len(null))
        chi = np.clip(solution.chi + move, given.bounds.lower, given.bounds.upper)
        (second,) = given.levels[1]
        excess = float(np.linalg.norm(second.residual(chi))) - solution.slacks[1]
        assert certified_excess(given, chi)[1] >= excess - 1e-9
