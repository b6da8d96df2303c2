"""The deadline of a solve: looked at before each iteration, and told in the status."""

import numpy as np

from lexstack.mpc import Outcome
from lexstack.mpc.iteration_clock import IterationClock
from lexstack.options import build
from lexstack_config.reader import read_yaml
from support.htmpc import CONFIG, HtmpcConfig, optimiser, random_objectives, random_start


def test_an_iteration_is_begun_where_the_longest_one_so_far_still_fits():
    now = [0.0]
    clock = IterationClock(10.0, lambda: now[0])
    begun = []
    for duration in (4.0, 2.0, 3.0, 1.0):
        begun.append(clock.enough())
        if begun[-1]:
            now[0] += duration
            clock.done()
    assert begun == [True, True, True, False], "one more may take 4 s, and 1 s is left"


def test_the_first_iteration_is_always_begun():
    now = [5.0]
    clock = IterationClock(1e-9, lambda: now[0])
    now[0] = 7.0
    assert clock.enough()
    clock.done()
    assert not clock.enough()


def test_without_a_deadline_the_clock_is_not_asked():
    def never():
        raise AssertionError

    clock = IterationClock(0.0, never)
    assert clock.enough()
    clock.done()


def test_a_late_solve_is_a_plan_and_says_so():
    rng = np.random.default_rng(1)
    start = random_start(rng)
    solver = optimiser(deadline=1e-9, early_stop_ratio=0.0)
    objectives = random_objectives(rng, start, solver)
    plan = solver.solve(start, objectives)
    first, second = plan.levels
    assert plan.solved
    assert first.outcome is Outcome.STEPPED
    assert (first.iterations, first.late) == (1, True)
    assert first.text.endswith("ended by the deadline")
    assert (second.outcome, second.iterations, second.late) == (Outcome.LATE, 0, True)
    assert not second.succeeded
    usual = optimiser(early_stop_ratio=0.0).solve(start, objectives)
    assert not any(level.late for level in usual.levels)


def test_files_without_a_method_mean_the_condensed_qp():
    """As bags do that were recorded before there were two."""
    content = read_yaml(CONFIG / "htmpc" / "lexstack.yaml")
    assert build(HtmpcConfig, {**content, "name": "own"}, "here").qp == "structured"
    del content["qp"]
    assert build(HtmpcConfig, content, "here").qp == "condensed"
