"""The order in which solvers are asked, and that nothing goes on unchecked."""

from dataclasses import replace

import numpy as np
import pytest

import lexstack_experiments.solvers  # noqa: F401 - brings quadprog
from lexstack.hqp import (
    DaqpCascade,
    FallbackSolver,
    NullSpaceCascade,
    Status,
    make_solver,
    rejection_reason,
)
from support.problems import problem

GIVEN = problem("tight", 6, 10, 3)
RIGHT = DaqpCascade().solve(GIVEN)


class Says:
    """A solver that returns what it is told to, and counts."""

    def __init__(self, name, **values):
        self.name = name
        self.values = values
        self.calls = 0

    def solve(self, given, warm=None):
        self.calls += 1
        return replace(DaqpCascade().solve(given, warm), **self.values)


FAILS = {"status": Status.FAILED, "reason": "level 1: cycling"}
WRONG = {
    "failed": (FAILS, "level 1: cycling"),
    "not finite": ({"chi": np.where(np.arange(10) == 3, np.nan, RIGHT.chi)}, "not finite"),
    "infinite": ({"chi": np.where(np.arange(10) == 3, np.inf, RIGHT.chi)}, "not finite"),
    "outside": ({"chi": GIVEN.bounds.upper + 1e-3}, "left the bounds by 0.001"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_answer_is_refused_and_the_next_solver_asked(case):
    values, words = WRONG[case]
    first, second, third = Says("one", **values), Says("two"), Says("three")
    solution = FallbackSolver(first, second, third).solve(GIVEN)
    assert solution.solved
    assert solution.reason == ""
    assert solution.chi.tobytes() == RIGHT.chi.tobytes()
    assert solution.note.startswith("one: ")
    assert words in solution.note
    assert solution.note.endswith("solved by two")
    assert (first.calls, second.calls, third.calls) == (1, 1, 0)


@pytest.mark.parametrize("case", WRONG)
def test_where_all_fail_the_solution_says_so_and_why(case):
    values, words = WRONG[case]
    solution = FallbackSolver(Says("one", **values), Says("two", **FAILS)).solve(GIVEN)
    assert solution.status is Status.FAILED
    assert solution.reason.startswith("one: ")
    assert words in solution.reason
    assert "two: level 1: cycling" in solution.reason
    assert "\n" not in solution.reason
    assert rejection_reason(solution, GIVEN.bounds)


def test_a_right_answer_costs_no_second_solver_and_leaves_no_note():
    second = Says("two")
    solution = FallbackSolver(Says("one"), second).solve(GIVEN)
    assert solution.note == ""
    assert second.calls == 0


def test_rounding_outside_of_the_box_is_no_failure():
    chi = RIGHT.chi + np.where(RIGHT.active > 0, 0.5e-7, 0.0)
    assert RIGHT.active.any()
    assert rejection_reason(replace(RIGHT, chi=chi), GIVEN.bounds) == ""
    assert rejection_reason(replace(RIGHT, chi=chi + 1e-6), GIVEN.bounds)


@pytest.mark.parametrize("name", ["daqp", "proxqp", "quadprog"])
def test_the_configured_solver_is_backed_by_another_library(name, monkeypatch):
    def fails(self, given, warm=None):
        return replace(RIGHT, chi=np.zeros(10), **FAILS)

    # All are one class with different backends: only the one with guesses fails.
    right = NullSpaceCascade.solve

    def solve(self, given, warm=None):
        return fails(self, given) if self._guesses else right(self, given, warm)

    monkeypatch.setattr(NullSpaceCascade, "solve", solve)
    solution = make_solver(name).solve(GIVEN)
    assert solution.solved
    np.testing.assert_allclose(solution.chi, RIGHT.chi, atol=1e-9)
    assert solution.note.startswith(f"{name}_cascade: level 1: cycling; solved by ")
    assert solution.note.endswith("daqp_cascade" if name == "proxqp" else "proxqp_cascade")
