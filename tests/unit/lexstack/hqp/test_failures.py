"""Failures are values: they name level and backend, and chi stays inside the bounds."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import lexstack_experiments.solvers  # noqa: F401 - brings quadprog and the oracle
from lexstack.errors import ConfigurationError, InputError
from lexstack.hqp import (
    SOLVERS,
    DaqpCascade,
    HqpProblem,
    NullSpaceCascade,
    ProxqpCascade,
    Status,
    make_solver,
)
from lexstack.hqp.backends import daqp as daqp_module
from lexstack.hqp.backends import proxqp as proxqp_module
from lexstack.hqp.backends.daqp import DaqpBackend
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from support.problems import problem

N = 10


def changed(level, **fields):
    """Return a nominal problem with fields of one task replaced by copies with a change."""
    whole = problem("nominal", 3, N, 3)
    levels = list(whole.levels)
    (task,) = levels[level]
    values = {}
    for name, (index, value) in fields.items():
        array = getattr(task, name).copy()
        array[index] = value
        values[name] = array
    levels[level] = (replace(task, **values),)
    return HqpProblem(tuple(levels), whole.bounds)


def assert_failed(solution, given, *words):
    assert solution.status is Status.FAILED
    assert not solution.solved
    assert "\n" not in solution.reason
    for word in words:
        assert word in solution.reason
    assert solution.chi.shape == (N,)
    assert np.isfinite(solution.chi).all()
    assert np.all(solution.chi >= given.bounds.lower)
    assert np.all(solution.chi <= given.bounds.upper)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_task_that_is_not_finite(name, level, value):
    for given in (
        changed(level, matrix=((0, 1), value)),
        changed(level, lower=(0, value), upper=(0, value)),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            solution = make_solver(name).solve(given)
        assert_failed(solution, given, f"level {level + 1} (")


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e-20, 1e20, 1e100, 1e150])
def test_numbers_out_of_all_proportion_end_in_a_value(name, size):
    whole = problem("infeasible", 3, N, 3, inequalities=True)
    for matrix, target, bound in ((size, 1, 1), (1, size, 1), (1, 1, size), (size, size, size)):
        levels = tuple(
            (LinearTask("t", matrix * task.matrix, target * task.lower, target * task.upper),)
            for (task,) in whole.levels
        )
        given = HqpProblem(levels, Bounds(bound * whole.bounds.lower, bound * whole.bounds.upper))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            solution = make_solver(name).solve(given)
        assert solution.solved == (solution.reason == "")
        assert np.isfinite(solution.chi).all()
        assert np.all(solution.chi >= given.bounds.lower)
        assert np.all(solution.chi <= given.bounds.upper)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_task_whose_row_is_empty(name):
    given = changed(1, lower=(0, 2.0), upper=(0, -2.0))
    assert_failed(make_solver(name).solve(given), given, "level 2 (", "lower end")


@pytest.mark.parametrize(
    ("lower", "upper"),
    [(0.3, 0.2), (np.nan, 1.0), (-1.0, np.nan), (np.inf, np.inf), (-np.inf, -np.inf)],
)
@pytest.mark.parametrize("name", SOLVERS)
def test_bounds_that_hold_no_number(name, lower, upper):
    whole = problem("nominal", 3, N, 2)
    low, high = np.full(N, 0.1), np.full(N, 0.9)
    low[4], high[4] = lower, upper
    solution = make_solver(name).solve(HqpProblem(whole.levels, Bounds(low, high)))
    assert solution.status is Status.FAILED
    assert "joint 4" in solution.reason
    others = np.arange(N) != 4
    np.testing.assert_array_equal(solution.chi[others], 0.1)
    assert solution.chi[4] == 0.0


class Broken(DaqpBackend):
    """A backend that fails, in one of three ways, when it is asked for the second time."""

    name = "broken"

    def __init__(self, way):
        self.way = way
        self.calls = 0

    def predict_active_set(self, hierarchy, lower, upper, guess):
        if self.way == "raises":
            raise RuntimeError("no idea")

    def solve(self, qp, guess):
        self.calls += 1
        sides = super().solve(qp, guess)
        if self.calls == 1:
            return sides
        if self.way == "raises":
            raise ValueError("out of luck")
        if self.way == "lies":
            return -sides
        return "out of luck"


@pytest.mark.parametrize("way", ["raises", "says so"])
@pytest.mark.parametrize("guesses", [True, False])
def test_a_failing_backend_leaves_the_levels_above_solved(way, guesses):
    given = problem("tight", 6, N, 3)
    whole = DaqpCascade().solve(given)
    backend = Broken(way)
    solution = NullSpaceCascade(backend, guesses).solve(given)
    assert backend.calls == 2
    assert_failed(solution, given, "level 2 (", "broken", "out of luck")
    assert solution.slacks[0] == pytest.approx(whole.slacks[0], abs=1e-10)
    assert solution.slacks[1] > whole.slacks[1] + 1e-3


def test_a_lying_backend_is_found_out():
    given = problem("tight", 6, N, 3)
    expected = DaqpCascade().solve(given)
    solution = NullSpaceCascade(Broken("lies"), guesses=False).solve(given)
    np.testing.assert_allclose(solution.chi, expected.chi, atol=1e-10)


def test_the_iteration_limit_of_proxqp_is_a_failure(monkeypatch):
    monkeypatch.setattr(proxqp_module, "_ITERATIONS", 1)
    given = problem("tight", 6, N, 3)
    solution = ProxqpCascade(guesses=False).solve(given)
    assert_failed(solution, given, "level 1 (", "proxqp", "PROXQP_MAX_ITER_REACHED")


def test_the_iteration_limit_of_daqp_is_a_failure(monkeypatch):
    monkeypatch.setattr(daqp_module, "_ITERATIONS", 1)
    given = problem("tight", 6, N, 3)
    solution = DaqpCascade(guesses=False).solve(given)
    assert_failed(solution, given, "level 1 (", "daqp", "iteration limit")


def test_a_task_of_another_length_raises():
    task = LinearTask.equality("robot_a/arm", np.eye(3), np.zeros(3))
    given = HqpProblem(((task,),), Bounds(-np.ones(4), np.ones(4)))
    with pytest.raises(InputError, match=r"robot_a/arm.*chi of length 4"):
        make_solver("daqp").solve(given)


def test_an_unknown_solver_is_told_the_known_ones():
    known = r"unknown solver 'mosek'; known: kernel, daqp, proxqp.* lexstack_experiments\.solvers$"
    with pytest.raises(ConfigurationError, match=known):
        make_solver("mosek")
