"""Adding a level never worsens those above, against an independent oracle and against itself."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lexstack.hqp import DaqpCascade, HqpProblem, KernelSolver, ProxqpCascade, Solution, Status
from lexstack_experiments.hierarchies.random_problems import SINGULAR, problems
from lexstack_experiments.hierarchies.score import score
from lexstack_experiments.solvers import QuadprogCascade, lexicographic_oracle
from support.problems import KINDS, near_singular, problem, truncated

EXCESS = 1e-8
SINGULAR_EXCESS = 1e-5
SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(8, 24)
SOLVERS = {
    "kernel": KernelSolver(),
    "daqp": DaqpCascade(),
    "daqp, every level": DaqpCascade(guesses=False),
    "proxqp": ProxqpCascade(),
    "proxqp, every level": ProxqpCascade(guesses=False),
    "quadprog": QuadprogCascade(),
    "quadprog, every level": QuadprogCascade(guesses=False),
}


def assert_inside(given: HqpProblem, solution: Solution):
    assert np.all(solution.chi >= given.bounds.lower)
    assert np.all(solution.chi <= given.bounds.upper)


def assert_strict(given: HqpProblem):
    oracle = lexicographic_oracle(given)
    # Where the oracle itself has not arrived it proves nothing; it must not hide that.
    assert max(level.violation for level in oracle) < EXCESS
    optimum = np.array([level.optimum for level in oracle])
    for name, solver in SOLVERS.items():
        solution = solver.solve(given)
        assert solution.status is Status.SOLVED, (name, solution.reason)
        assert_inside(given, solution)
        residuals = [
            np.linalg.norm(np.concatenate([task.residual(solution.chi) for task in level]))
            for level in given.levels
        ]
        np.testing.assert_allclose(solution.slacks, residuals, atol=1e-12, err_msg=name)
        assert np.max(solution.slacks - optimum) <= EXCESS, (name, solution.slacks - optimum)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_the_default_solver_on_600_problems_of_10_to_80_variables_and_1_to_5_levels(seed):
    # Each of them with a certificate that trusts nothing of the solver.
    scores = score(KernelSolver(), problems(seed, 600))
    assert sum(len(part.times) for part in scores.values()) == 600
    for kind, part in scores.items():
        assert part.failures == 0, kind
        assert part.outside <= 0.0, kind
        assert part.excess <= (SINGULAR_EXCESS if kind == SINGULAR else EXCESS), kind


@settings(max_examples=40, derandomize=True, deadline=None)
@given(seed=SEEDS, n=SIZES, levels=st.integers(1, 4))
@pytest.mark.parametrize("kind", KINDS)
def test_every_level_is_as_good_as_the_oracles(kind, seed, n, levels):
    assert_strict(problem(kind, seed, n, levels))


@settings(max_examples=40, derandomize=True, deadline=None)
@given(seed=SEEDS, n=SIZES, levels=st.integers(1, 4))
@pytest.mark.parametrize("kind", KINDS)
def test_inequality_rows_are_as_strict(kind, seed, n, levels):
    assert_strict(problem(kind, seed, n, levels, inequalities=True))


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS, n=SIZES, inequalities=st.booleans(), kind=st.sampled_from(KINDS))
def test_adding_a_level_changes_nothing_above(seed, n, inequalities, kind):
    whole = problem(kind, seed, n, 4, inequalities)
    for name, solver in SOLVERS.items():
        full = solver.solve(whole)
        for levels in range(1, 4):
            part = solver.solve(truncated(whole, levels))
            assert part.solved, (name, part.reason)
            np.testing.assert_allclose(full.slacks[:levels], part.slacks, atol=EXCESS, err_msg=name)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS, n=SIZES, inequalities=st.booleans(), kind=st.sampled_from(KINDS))
def test_all_ways_lead_to_the_same_chi(seed, n, inequalities, kind):
    # The optimum is unique, because what no level uses goes into the smallest chi.
    whole = problem(kind, seed, n, 3, inequalities)
    chis = [solver.solve(whole).chi for solver in SOLVERS.values()]
    for chi in chis[1:]:
        np.testing.assert_allclose(chi, chis[0], atol=1e-7)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(
    seed=SEEDS,
    n=SIZES,
    rows=st.integers(2, 8),
    exponent=st.floats(-16.0, -2.0),
)
@example(seed=3, n=20, rows=6, exponent=-np.inf)
def test_near_a_singularity_level_0_stays_optimal_and_chi_inside(seed, n, rows, exponent):
    given = near_singular(seed, n, rows, 10.0**exponent)
    (oracle,) = lexicographic_oracle(truncated(given, 1))
    for name, solver in SOLVERS.items():
        solution = solver.solve(given)
        assert_inside(given, solution)
        # ProxQP may stall here; then it has to say so.
        assert solution.solved or name.startswith("proxqp"), (name, solution.reason)
        if solution.solved:
            assert solution.slacks[0] - oracle.optimum <= SINGULAR_EXCESS, name


@settings(max_examples=40, derandomize=True, deadline=None)
@given(seed=SEEDS, other=SEEDS, n=SIZES, kind=st.sampled_from(KINDS))
def test_a_warm_start_changes_the_time_and_not_the_optimum(seed, other, n, kind):
    whole = problem(kind, seed, n, 3)
    wrong = SOLVERS["daqp"].solve(problem("infeasible", other, n, 2))
    for name, solver in SOLVERS.items():
        cold = solver.solve(whole)
        for warm in (cold, wrong):
            chi = solver.solve(whole, warm).chi
            np.testing.assert_allclose(chi, cold.chi, atol=1e-9, err_msg=name)
