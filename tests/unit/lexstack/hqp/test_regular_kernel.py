"""The compiled test of regular levels decides as the plain one."""

import collections

import numpy as np
import pytest

from lexstack.compiled import kernel
from lexstack.control.kernels import load_kernels
from lexstack.hqp import HqpProblem
from lexstack.hqp.chain_levels import ChainLevels
from lexstack.hqp.groups import groups_of
from lexstack.hqp.kernel import regular as compiled
from lexstack.hqp.regular import regular_levels
from lexstack.limits import Bounds
from lexstack.references import measured
from lexstack.tasks import build_stack
from lexstack_config.parts import build_team
from support.scenario import resolved

RNG = np.random.default_rng(3)


def decisions(stack, spread, count):
    """Return how often both tests say what, at random states with targets nearby."""
    load_kernels()
    scenario = resolved()
    team, seen = build_team(scenario), collections.Counter()
    built = build_stack(scenario.stacks[stack], team)
    home = team.home()
    for _ in range(count):
        q = home + spread * RNG.normal(size=team.nq)
        goals = measured(team, q + 10.0 ** RNG.uniform(-4.0, 0.0) * RNG.normal(size=team.nq))
        kinematics = team.kinematics(team.at_rest(q))
        box = Bounds(np.full(team.n, -1.0), np.full(team.n, 1.0))
        problem = HqpProblem(built.linearise(kinematics, goals), box)
        for group in groups_of(problem, team.slices):
            levels = group.levels(problem)
            plain = regular_levels(levels, None, kinematics, group.places) == len(levels)
            fast = kernel("lexstack.hqp.kernel.regular")
            chain = ChainLevels.of(group, problem)
            seen[plain, chain.regular(problem, kinematics, fast)] += 1
    return seen


@pytest.mark.parametrize("stack", ["reach_base", "posture_mid_range"])
def test_the_compiled_test_decides_as_the_plain_one(stack):
    seen = decisions(stack, 0.6, 300)
    assert set(seen) == {(True, True), (False, False)}
    assert min(seen.values()) > 20


def test_eigenvalues_are_those_of_lapack():
    for n in range(1, 9):
        matrix = RNG.normal(size=(n, n))
        matrix = matrix @ matrix.T
        turned, vectors = matrix.copy(), np.empty((n, n))
        compiled.diagonalise(turned, vectors)
        np.testing.assert_allclose(
            np.sort(np.diag(turned)), np.linalg.eigvalsh(matrix), rtol=0.0, atol=1e-13 * n * n
        )
        np.testing.assert_allclose(
            vectors @ np.diag(np.diag(turned)) @ vectors.T, matrix, atol=1e-12
        )


def test_a_matrix_that_is_not_definite_or_no_number_has_no_factor():
    assert compiled.cholesky(np.diag([1.0, 2.0]), 2)
    assert not compiled.cholesky(np.diag([1.0, -1e-9]), 2)
    assert not compiled.cholesky(np.array([[1.0, np.nan], [np.nan, 1.0]]), 2)
