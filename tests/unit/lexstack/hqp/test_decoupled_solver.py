"""What no task couples is solved apart: the same optimum, put together, at a linear cost."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.hqp import ClusteredSolver, DaqpCascade, HqpProblem, Status
from lexstack.hqp.coupling import Structure
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from support.problems import KINDS, problem, side_by_side

DENSE = DaqpCascade()


class Watching:
    """A solver that remembers how many joints it was asked for."""

    name = "watching"

    def __init__(self):
        self.sizes = []

    def solve(self, given, warm=None):
        self.sizes.append(given.bounds.lower.size)
        return DENSE.solve(given, warm)


def subproblems_of(given, size):
    return Structure(size).subproblems_of(given)


def robots(count, kind="nominal", inequalities=False, seed=0):
    parts = [problem(kind, seed + i, 10, 3, inequalities) for i in range(count)]
    return side_by_side(parts)


def with_task(given, level, task):
    levels = list(given.levels)
    levels[level] = (*levels[level], task)
    return HqpProblem(tuple(levels), given.bounds)


@pytest.mark.parametrize("inequalities", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_equal_to_the_dense_solution(kind, inequalities):
    for seed in range(5):
        given = robots(6, kind, inequalities, 10 * seed)
        dense = DENSE.solve(given)
        for size in (10, 20, 40):
            solution = ClusteredSolver(DENSE, size).solve(given)
            assert solution.solved
            np.testing.assert_allclose(solution.chi, dense.chi, atol=1e-9)
            np.testing.assert_allclose(solution.slacks, dense.slacks, atol=1e-9)
            np.testing.assert_array_equal(solution.active, dense.active)
            np.testing.assert_array_equal(solution.rows, dense.rows)


def test_each_part_is_solved_alone_and_of_the_size_asked_for():
    watching = Watching()
    ClusteredSolver(watching, 20).solve(robots(6))
    assert watching.sizes == [20, 20, 20]


def test_a_problem_of_one_part_goes_through_as_it_is():
    given = robots(2)
    watching = Watching()
    solution = ClusteredSolver(watching, 20).solve(given)
    assert watching.sizes == [20]
    assert solution.chi.tobytes() == DENSE.solve(given).chi.tobytes()


def test_a_task_of_two_robots_couples_them_wherever_they_stand():
    matrix = np.zeros((1, 60))
    matrix[0, [3, 57]] = 1.0
    given = with_task(robots(6), 1, LinearTask.equality("both", matrix, np.array([0.2])))
    parts = subproblems_of(given, 10)
    columns = [np.arange(60)[part.columns].tolist() for part in parts]
    assert columns[0] == [*range(10), *range(50, 60)]
    assert columns[1:] == [list(range(10 * i, 10 * i + 10)) for i in range(1, 5)]
    solution = ClusteredSolver(DENSE, 10).solve(given)
    np.testing.assert_allclose(solution.chi, DENSE.solve(given).chi, atol=1e-9)


def test_a_chain_of_couplings_is_one_part():
    tasks = []
    for first in (40, 0, 20, 30, 10):  # 0-10, 10-20, ... in no order
        matrix = np.zeros((1, 60))
        matrix[0, [first, first + 10]] = 1.0, -1.0
        tasks.append(LinearTask.equality(f"from {first}", matrix, np.zeros(1)))
    given = robots(6)
    for task in tasks:
        given = with_task(given, 0, task)
    assert len(subproblems_of(given, 10)) == 1


@pytest.mark.parametrize("scale", [1.0, -2.5])
def test_follow_chi_couples_nothing(scale):
    given = robots(6)
    target = np.linspace(-0.4, 0.4, 60)
    follow = LinearTask.equality("follow_chi", scale * np.eye(60), scale * target)
    given = HqpProblem((given.levels[0], (follow,)), given.bounds)
    assert len(subproblems_of(given, 10)) == 6
    dense = DENSE.solve(given)
    solution = ClusteredSolver(DENSE, 10).solve(given)
    np.testing.assert_allclose(solution.chi, dense.chi, atol=1e-9)
    np.testing.assert_allclose(solution.slacks, dense.slacks, atol=1e-9)


def test_an_entry_however_small_couples():
    given = robots(6)
    tiny = np.zeros((1, 60))
    tiny[0, [0, 59]] = 1.0, 1e-300
    assert (
        len(subproblems_of(with_task(given, 0, LinearTask("t", tiny, *np.zeros((2, 1)))), 10)) == 5
    )
    almost = np.eye(60)
    almost[0, 59] = 1e-300
    task = LinearTask.equality("almost", almost, np.zeros(60))
    assert len(subproblems_of(with_task(given, 0, task), 10)) == 1


def test_tasks_without_rows_or_columns_and_levels_without_tasks():
    given = robots(6)
    zero = LinearTask.equality("zero", np.zeros((2, 60)), np.array([3.0, 4.0]))
    empty = LinearTask.equality("empty", np.zeros((0, 60)), np.zeros(0))
    levels = (given.levels[0], (), (zero, empty), given.levels[1])
    solution = ClusteredSolver(DENSE, 10).solve(HqpProblem(levels, given.bounds))
    assert solution.slacks[1] == 0.0
    assert solution.slacks[2] == pytest.approx(5.0)


def test_a_warm_start_reaches_every_part():
    given = robots(6, "infeasible", inequalities=True)
    solver = ClusteredSolver(DENSE, 20)
    cold = solver.solve(given)
    assert cold.active.any()
    assert cold.rows.any()
    np.testing.assert_allclose(solver.solve(given, cold).chi, cold.chi, atol=1e-9)
    other = ClusteredSolver(DENSE, 20).solve(robots(5))
    np.testing.assert_allclose(solver.solve(given, other).chi, cold.chi, atol=1e-9)
    short = replace(cold, rows=cold.rows[:7])
    np.testing.assert_allclose(solver.solve(given, short).chi, cold.chi, atol=1e-9)


def test_a_part_that_fails_is_named_and_the_others_are_solved():
    given = robots(6)
    lower = given.bounds.lower.copy()
    lower[34] = 99.0
    broken = HqpProblem(given.levels, Bounds(lower, given.bounds.upper))
    solution = ClusteredSolver(DENSE, 10).solve(broken)
    assert solution.status is Status.FAILED
    assert "joints 30 to 39" in solution.reason
    assert "joint 4" in solution.reason
    others = np.r_[0:30, 40:60]
    np.testing.assert_allclose(solution.chi[others], DENSE.solve(given).chi[others], atol=1e-9)


def test_the_same_problem_gives_the_same_bits_whatever_was_solved_before():
    given = robots(6)
    used = ClusteredSolver(DENSE, 20)
    used.solve(robots(6, "tight", seed=50))
    assert used.solve(given).chi.tobytes() == ClusteredSolver(DENSE, 20).solve(given).chi.tobytes()


def test_a_task_of_another_length_raises():
    task = LinearTask.equality("robot_a/arm", np.eye(3), np.zeros(3))
    given = HqpProblem(((task,),), Bounds(-np.ones(60), np.ones(60)))
    with pytest.raises(InputError, match=r"robot_a/arm.*chi of length 60"):
        ClusteredSolver(DENSE, 20).solve(given)


def test_a_matrix_that_cannot_change_is_looked_at_once_and_one_that_can_every_time():
    given = robots(6)
    matrix = np.zeros((1, 60))
    matrix[0, 3] = 1.0
    task = LinearTask.equality("t", matrix, np.zeros(1))
    coupled = with_task(given, 0, task)
    structure = Structure(10)
    assert len(structure.subproblems_of(coupled)) == 6
    matrix[0, 57] = 1.0
    assert len(structure.subproblems_of(coupled)) == 5
    matrix.setflags(write=False)
    assert len(structure.subproblems_of(coupled)) == 5
    assert len(structure.subproblems_of(coupled)) == 5
    for first in range(0, 50, 10):  # other matrices, at whatever place in memory
        other = np.zeros((1, 60))
        other[0, [first, first + 10]] = 1.0
        other.setflags(write=False)
        assert (
            len(
                structure.subproblems_of(
                    with_task(given, 0, LinearTask.equality("o", other, np.zeros(1)))
                )
            )
            == 5
        )
        del other
