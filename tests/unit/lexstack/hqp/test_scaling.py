"""Problems whose answers were wrong and said solved, because tolerances were absolute."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack.hqp import (
    DaqpCascade,
    HqpProblem,
    ProxqpCascade,
    Solution,
    Status,
    cascade,
    make_solver,
    unmet,
)
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from lexstack_experiments.solvers import OracleSolver, QuadprogCascade
from support.exact import exact_optimum

INF = np.inf
SOLVERS = {
    "daqp": DaqpCascade(),
    "daqp, every level": DaqpCascade(guesses=False),
    "proxqp": ProxqpCascade(),
    "proxqp, every level": ProxqpCascade(guesses=False),
    "quadprog": QuadprogCascade(),
    "quadprog, every level": QuadprogCascade(guesses=False),
}
EVERY = pytest.mark.parametrize("name", SOLVERS)


def row(*coefficients, lower=-INF, upper=INF):
    return LinearTask(
        "row", np.array([coefficients], dtype=float), np.array([lower]), np.array([upper])
    )


def to(value, *coefficients):
    return row(*coefficients, lower=float(value), upper=float(value))


def problem(levels, lower, upper):
    box = Bounds(np.array(lower, dtype=float), np.array(upper, dtype=float))
    return HqpProblem(tuple(tuple(level) for level in levels), box)


def warm(*active):
    n = len(active)
    return Solution(
        np.zeros(n), np.zeros(1), Status.SOLVED, "", np.array(active, dtype=np.int8), 0.0
    )


def every_side(n):
    return [np.array(sides) - 1 for sides in np.ndindex(*[3] * n)]


CASES = {
    "large inequality rows above a large equality": (
        problem(
            [[row(768, 0, lower=-768), row(-256, -512, lower=768)], [to(-768, -768, 0)]],
            [0, -INF],
            [INF, -1],
        ),
        [1, -2],
    ),
    "a large equality above a large inequality": (
        problem([[to(-256, 256, -384, -384)], [row(0, 0, 256, lower=384)]], [-INF] * 3, [0, 0, 1]),
        [0, -1 / 3, 1],
    ),
    "large rows above small ones": (
        problem([[to(162, -510, -420)], [to(-2.7, -0.2, 2), to(1.3, 0, -1.3)]], [-1] * 2, [1] * 2),
        [43 / 85, -1],
    ),
    "large inequality rows that contradict each other": (
        problem(
            [[row(3072, 2048, lower=3072), row(-3072, -3072, lower=2048)]], [-INF, -4], [4, INF]
        ),
        [3.5, -4],
    ),
    "small rows": (problem([[to(2e-6, 1e-6, 1e-6)]], [0, 0], [3, 3]), [1, 1]),
    "a weak row in a level of norm 1": (
        problem([[to(0.5, 1, 0), to(5e-7, 0, 1e-5)], [to(-9, 0, 1)]], [-INF, 0], [INF, 10]),
        [0.5, 0.05],
    ),
    "a weak row that cannot be met beside a strong one that can": (
        problem([[to(0.5, 1, 0), to(1e-4, 1e-5, 1e-5)], [to(-9, 0, 1)]], [-1, 0], [1, 1]),
        [0.5 + 1e-10 * 8.5, 1],
    ),
    "a level whose only row is small gives way to none": (
        problem([[to(1024, 1024), to(2**-10, 2**-8)], [to(9, 1)]], [-9], [9]),
        [(1 + 2**-38) / (1 + 2**-36)],
    ),
}


@EVERY
@pytest.mark.parametrize("case", CASES)
def test_the_exact_answer_cold_and_from_every_active_set(case, name):
    given, chi = CASES[case]
    solver = SOLVERS[name]
    np.testing.assert_allclose([float(x) for x in exact_optimum(given)], chi, atol=1e-12)
    for start in (None, *(warm(*sides) for sides in every_side(len(chi)))):
        solution = solver.solve(given, start)
        assert solution.solved, solution.reason
        np.testing.assert_allclose(solution.chi, chi, atol=1e-10)


@EVERY
@pytest.mark.parametrize("size", [2.0**-20, 1e-6, 1.0, 1e6, 2.0**20])
def test_small_rows_whose_target_changes_sign(size, name):
    def wanted(d):
        return problem([[to(size * d, size, size)]], [0, 0], [3, 3])

    before = SOLVERS[name].solve(wanted(-1.0))
    np.testing.assert_array_equal(before.active, [-1, -1])
    np.testing.assert_allclose(SOLVERS[name].solve(wanted(2.0), before).chi, 1.0, atol=1e-12)


@EVERY
def test_a_weak_row_whose_target_comes_back(name):
    def wanted(target):
        levels = [[to(0.5, 1, 0), to(target, 0, 1e-5)], [to(-9, 0, 1)]]
        return problem(levels, [-INF, 0], [INF, 10])

    before = SOLVERS[name].solve(wanted(-5e-7))
    solution = SOLVERS[name].solve(wanted(5e-7), before)
    np.testing.assert_allclose(solution.chi, [0.5, 0.05], atol=1e-12)


@pytest.mark.parametrize("size", [2.0**-30, 2.0**-9, 1.0, 2.0**9, 2.0**30])
@EVERY
def test_a_level_times_a_power_of_two_has_the_same_bits(size, name):
    # Rows between 1/16 and 16 are taken as they are; all others come to norms of 1/2 to 1.
    def of(factor):
        levels = [
            [to(factor * 4.0, factor * 1.0, factor * 0.5, factor * 0.25)],
            [row(0.5, -0.5, 1.0, lower=1.5), to(0.3, 1, 0, 0)],
        ]
        return problem(levels, [-1] * 3, [1] * 3)

    chi = SOLVERS[name].solve(of(2.0**12)).chi
    if size == 1.0:
        np.testing.assert_allclose(SOLVERS[name].solve(of(size)).chi, chi, atol=1e-15)
    else:
        assert SOLVERS[name].solve(of(size)).chi.tobytes() == chi.tobytes()


@EVERY
def test_scaling_does_not_change_the_weights_of_rows_that_contradict_each_other(name):
    # x = 0 with weight 1, x = 1 with weight w: the optimum is w^2 / (1 + w^2).
    for weight in (1e-4, 1e-3, 1e-2, 0.3, 1.0, 30.0, 1e2, 1e3, 1e4):
        given = problem([[to(0, 1), to(weight, weight)]], [-9], [9])
        (chi,) = SOLVERS[name].solve(given).chi
        assert chi == pytest.approx(weight**2 / (1.0 + weight**2), rel=1e-12)


@EVERY
def test_a_row_of_rounding_asks_for_nothing(name):
    # As in the Jacobian of an arm that cannot move its tool that way.
    noise = LinearTask(
        "arm", np.array([[1.0, 0.5], [1e-17, -3e-17]]), np.array([0.3, 0.2]), np.array([0.3, 0.2])
    )
    given = problem([[noise], [to(0.1, 0, 1)]], [-1, -1], [1, 1])
    np.testing.assert_allclose(SOLVERS[name].solve(given).chi, [0.25, 0.1], atol=1e-12)


@EVERY
@pytest.mark.parametrize("end", [1e5, 1e6, 1e8])
def test_an_active_set_that_names_far_ends_does_not_take_chi_there(end, name):
    levels = [[to(4, 1, -1, -1, -2), to(3, -1, 1, 1, -1)]]
    given = problem(levels, [-end] * 4, [end] * 4)
    for sides in ((1, 1, 1, 0), (1, -1, 1, -1), (-1, -1, -1, -1)):
        chi = SOLVERS[name].solve(given, warm(*sides)).chi
        np.testing.assert_allclose(chi, [-2 / 9, 2 / 9, 2 / 9, -7 / 3], atol=1e-10)


@pytest.mark.parametrize("name", ["daqp", "proxqp", "quadprog", "oracle"])
def test_a_chi_without_joints(name):
    task = LinearTask("row", np.empty((1, 0)), np.ones(1), np.ones(1))
    for levels in ((), ((task,),), ((task,), (replace(task, upper=np.full(1, 2.0)),))):
        solution = make_solver(name).solve(HqpProblem(levels, Bounds(np.empty(0), np.empty(0))))
        assert solution.solved
        assert solution.chi.shape == (0,)
        np.testing.assert_array_equal(solution.slacks, np.ones(len(levels)))


@pytest.mark.parametrize("contradicting", [True, False])
def test_the_oracle_on_rows_that_depend_on_each_other_without_bounds(contradicting):
    same = [1, -1, 1, -1, 1, -1]
    levels = [[to(-3, *same), to(2, *same)]] if contradicting else [[to(-3, *same)], [to(2, *same)]]
    given = problem(levels, [-INF] * 6, [INF] * 6)
    solution = OracleSolver().solve(given)
    assert solution.solved
    expected = np.array(same) * (-0.5 if contradicting else -3.0) / 6.0
    np.testing.assert_allclose(solution.chi, expected, atol=1e-9)


def test_the_oracle_refuses_rows_that_it_cannot_weigh():
    given = problem([[to(1, 1e6, 0), to(1, 1e6, 1e-3)], [to(0, 0, 1)]], [-1] * 2, [1] * 2)
    assert OracleSolver().solve(given).solved
    given = problem([[to(1, 1e6, 0), to(1, 0, 1e-3)], [to(0, 0, 1)]], [-1] * 2, [1] * 2)
    solution = OracleSolver().solve(given)
    assert not solution.solved
    assert "differ too much in size" in solution.reason


def test_where_the_weights_of_a_level_are_not_resolved_the_solver_says_so(monkeypatch):
    monkeypatch.setattr(cascade, "solve_by_active_set", lambda *_, **__: None)
    monkeypatch.setattr(unmet, "solve_by_active_set", lambda *_, **__: None)
    monkeypatch.setattr(unmet, "_SINGLE_ROUNDS", 0)
    given = problem([[to(0, 1, 0), to(1e-3, 1e-3, 0)], [to(0.5, 0, 1)]], [-1] * 2, [1] * 2)
    solution = DaqpCascade().solve(given)
    assert solution.status is Status.FAILED
    assert "level 1 (" in solution.reason
    assert "differ too much in size" in solution.reason
    met = problem([[to(0, 1, 0), to(1e-3, 0, 1e-3)]], [-1] * 2, [1] * 2)
    np.testing.assert_allclose(DaqpCascade().solve(met).chi, [0, 1], atol=1e-12)


def many_rows(seed, n):
    rng = np.random.default_rng((seed, n))
    tasks = [
        LinearTask("rows", rng.normal(size=(30, n)), np.full(30, -INF), rng.normal(size=30))
        for _ in range(8)
    ]
    return problem([[task] for task in tasks], [-1] * n, [1] * n)


@pytest.mark.parametrize("name", ["daqp", "quadprog"])
def test_eight_levels_of_thirty_inequality_rows(name):
    solutions = {}
    for n in (80, 90, 100):
        for seed in range(6):
            solution = make_solver(name).solve(many_rows(seed, n))
            assert solution.solved, (n, seed, solution.reason)
            assert solution.note == "", (n, seed)
            solutions[n, seed] = solution.slacks
    other = make_solver("quadprog" if name == "daqp" else "daqp").solve(many_rows(0, 90))
    np.testing.assert_allclose(solutions[90, 0], other.slacks, atol=1e-9)


def test_eight_levels_of_thirty_inequality_rows_with_proxqp():
    given = many_rows(0, 90)
    solution = make_solver("proxqp").solve(given)
    assert solution.solved, solution.reason
    np.testing.assert_allclose(solution.slacks, DaqpCascade().solve(given).slacks, atol=1e-8)
