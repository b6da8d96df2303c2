"""Hierarchies small enough to be solved by hand, by every solver."""

import numpy as np
import pytest

from lexstack.hqp import DaqpCascade, HqpProblem, ProxqpCascade
from lexstack.limits import Bounds
from lexstack.types import LinearTask

SOLVERS = [
    DaqpCascade(),
    DaqpCascade(guesses=False),
    ProxqpCascade(),
    ProxqpCascade(guesses=False),
]
INF = np.inf


def row(*coefficients, lower=-INF, upper=INF):
    return LinearTask(
        "row", np.array([coefficients], dtype=float), np.array([lower]), np.array([upper])
    )


def to(value, *coefficients):
    return row(*coefficients, lower=value, upper=value)


def problem(*levels, bound=1.0):
    limit = np.full(levels[0][0].matrix.shape[1], bound)
    return HqpProblem(tuple(levels), Bounds(-limit, limit))


CASES = {
    "the second level moves where the first does not see it": (
        problem((to(1.0, 1, 1),), (to(2.0, 1, 0),)),
        [1.0, 0.0],
        [0.0, 1.0],
        [1, 0],
    ),
    "freedom that no level uses goes into the smallest chi": (
        problem((to(1.0, 1, 1),)),
        [0.5, 0.5],
        [0.0],
        [0, 0],
    ),
    "what the first level cannot reach does not stop the second": (
        problem((to(5.0, 1, 0),), (to(0.3, 1, 1),)),
        [1.0, -0.7],
        [4.0, 0.0],
        [1, 0],
    ),
    "the residual is the task's own, whatever the norms of its rows": (
        problem((to(20.0, 10, 0), to(0.0, 1, 0)), bound=5.0),
        [200.0 / 101.0, 0.0],
        [20.0 / np.sqrt(101.0)],
        [0, 0],
    ),
    "tasks of a level that contradict each other meet in the middle": (
        problem((to(0.0, 1, 0), to(0.4, 1, 0)), (to(0.9, 1, 1),)),
        [0.2, 0.7],
        [np.sqrt(0.08), 0.0],
        [0, 0],
    ),
    "an inequality of a higher level holds": (
        problem((row(1, 0, lower=0.5),), (to(0.0, 1, 0), to(0.8, 0, 1))),
        [0.5, 0.8],
        [0.0, 0.5],
        [0, 0],
    ),
    "an inequality that does not bind is not felt": (
        problem((row(1, 1, lower=-1.5, upper=1.5),), (to(0.4, 1, 0), to(0.8, 0, 1))),
        [0.4, 0.8],
        [0.0, 0.0],
        [0, 0],
    ),
    "an inequality that cannot hold is violated as little as possible": (
        problem((row(1, 0, lower=3.0),), (to(0.2, 0, 1), to(0.0, 1, 0))),
        [1.0, 0.2],
        [2.0, 1.0],
        [1, 0],
    ),
    "inequalities that contradict each other stay where they are": (
        problem((row(1, 0, lower=0.6), row(1, 0, upper=0.0)), (to(1.0, 1, 0),)),
        [0.3, 0.0],
        [np.sqrt(0.18), 0.7],
        [0, 0],
    ),
    "an inequality below gives way to the equality above": (
        problem((to(0.9, 1, 1),), (row(1, 1, upper=0.5), row(1, 0, upper=0.2)), (to(1.0, 1, 0),)),
        [0.2, 0.7],
        [0.0, 0.4, 0.8],
        [0, 0],
    ),
    "a bound that is missed by little counts as one that is missed by much": (
        HqpProblem(
            ((to(0.0, 1, 1),), (to(1.00001, 1, 0),)),
            Bounds(np.full(2, -9.0), np.array([1.0, 9.0])),
        ),
        [1.0, -1.0],
        [0.0, 1e-5],
        [1, 0],
    ),
    "no level at all": (HqpProblem((), Bounds(np.array([0.2]), np.array([1.0]))), [0.2], [], [-1]),
    "a level without tasks": (problem((to(0.5, 1, 0),), ()), [0.5, 0.0], [0.0, 0.0], [0, 0]),
    "bounds without end": (
        problem((to(40.0, 1, 1),), (to(70.0, 1, 0),), bound=INF),
        [70.0, -30.0],
        [0.0, 0.0],
        [0, 0],
    ),
}


@pytest.mark.parametrize("solver", SOLVERS, ids=["daqp", "daqp-levels", "proxqp", "proxqp-levels"])
@pytest.mark.parametrize("case", CASES)
def test_solved_by_hand(case, solver):
    given, chi, slacks, active = CASES[case]
    solution = solver.solve(given)
    assert solution.solved
    assert solution.reason == ""
    np.testing.assert_allclose(solution.chi, chi, atol=1e-9)
    np.testing.assert_allclose(solution.slacks, slacks, atol=1e-9)
    np.testing.assert_array_equal(solution.active, active)
    assert solution.solve_time > 0.0


def test_two_joints_at_their_bounds_for_a_level_leave_it_nothing_to_move():
    # Both are pressed by level 0: taken as inequalities they would leave level 1 a feasible set
    # without interior, on which solvers stall.
    given = problem((to(5.0, 1, 1, 0),), (to(0.3, 1, -1, 1),))
    for solver in SOLVERS:
        solution = solver.solve(given)
        np.testing.assert_allclose(solution.chi, [1.0, 1.0, 0.3], atol=1e-12)


def test_integer_rows_and_rows_of_other_layouts_are_taken():
    matrix = np.asfortranarray(np.arange(6).reshape(2, 3))
    given = HqpProblem(
        ((LinearTask("whole", matrix, np.array([1, 2]), np.array([1, 2])),),),
        Bounds(np.full(3, -9.0), np.full(3, 9.0)),
    )
    for solver in SOLVERS:
        expected = np.linalg.pinv(matrix) @ [1.0, 2.0]
        np.testing.assert_allclose(solver.solve(given).chi, expected, atol=1e-12)
