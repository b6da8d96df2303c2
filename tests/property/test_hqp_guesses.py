"""Guesses cost time and never the optimum: whatever is guessed, wrong is not taken for right."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.hqp import DaqpCascade, Hierarchy, NullSpaceCascade
from lexstack.hqp.active_set import WorkingSet, solve_by_active_set
from lexstack.hqp.backends.daqp import DaqpBackend
from support.problems import KINDS, problem

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(8, 24)
CASCADE = DaqpCascade(guesses=False)


class Dice(DaqpBackend):
    """A backend that says at random which rows hold, or takes away some that do."""

    def __init__(self, seed, share):
        self.rng = np.random.default_rng(seed)
        self.share = share

    def predict_active_set(self, hierarchy, lower, upper, guess):
        sides = super().predict_active_set(hierarchy, lower, upper, guess)
        soft = ~hierarchy.equal
        ends = [
            np.concatenate(x)
            for x in ((lower, hierarchy.lower[soft]), (upper, hierarchy.upper[soft]))
        ]
        return None if sides is None else self.spoil(sides, *ends)

    def solve(self, qp, guess):
        return self.spoil(super().solve(qp, guess), qp.lower, qp.upper)

    def spoil(self, sides, lower, upper):
        spoilt = sides.copy()
        chosen = self.rng.random(sides.size) < self.share
        spoilt[chosen] = self.rng.integers(-1, 2, sides.size)[chosen]
        spoilt[np.isinf(np.where(spoilt > 0, upper, lower))] = 0
        return spoilt


@settings(max_examples=150, derandomize=True, deadline=None)
@given(seed=SEEDS, n=SIZES, kind=st.sampled_from(KINDS), share=st.floats(0.0, 1.0))
def test_a_wrong_guess_of_the_whole_is_refused_or_corrected(seed, n, kind, share):
    rng = np.random.default_rng(seed)
    whole = problem(kind, seed, n, 1 + seed % 3, inequalities=bool(seed % 2))
    optimum = CASCADE.solve(whole)
    hierarchy = Hierarchy(whole.levels, n)
    lower, upper = whole.bounds.lower, whole.bounds.upper
    for rounds in (1, 4):
        joints = optimum.active.copy()
        chosen = rng.random(n) < share
        joints[chosen] = rng.integers(-1, 2, n)[chosen]
        m = hierarchy.lower.size
        sides = (rng.integers(-1, 2, m) * (rng.random(m) < share)).astype(np.int8)
        end = np.where(sides > 0, hierarchy.upper, hierarchy.lower)
        sides[hierarchy.equal | np.isinf(end)] = 0
        chi = solve_by_active_set(hierarchy, lower, upper, WorkingSet(joints, sides), rounds)
        if chi is not None:
            np.testing.assert_allclose(chi, optimum.chi, atol=1e-8)


@settings(max_examples=150, derandomize=True, deadline=None)
@given(seed=SEEDS, n=SIZES, kind=st.sampled_from(KINDS), share=st.floats(0.0, 1.0))
def test_a_backend_that_throws_dice_costs_time_only(seed, n, kind, share):
    whole = problem(kind, seed, n, 3, inequalities=bool(seed % 2))
    expected = CASCADE.solve(whole)
    for guesses in (True, False):
        solution = NullSpaceCascade(Dice(seed, share), guesses).solve(whole)
        if solution.solved:
            np.testing.assert_allclose(solution.chi, expected.chi, atol=1e-8)
        else:
            assert "no optimum near" in solution.reason


def test_the_cascade_is_seldom_needed():
    calls = []

    class Counting(DaqpBackend):
        def solve(self, qp, guess):
            calls.append(1)
            return super().solve(qp, guess)

    solver = NullSpaceCascade(Counting())
    kinds = ("nominal", "tight", "infeasible")
    problems = [problem(kind, seed, 20, 3) for kind in kinds for seed in range(40)]
    needed = 0
    for whole in problems:
        calls.clear()
        assert solver.solve(whole).solved
        needed += bool(calls)
    assert needed <= 0.05 * len(problems)
