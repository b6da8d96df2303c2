"""The peers that a bench measures beside our solver."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from lexstack.hqp import HqpProblem, make_solver
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from lexstack_experiments.benches.hqp_runs import Local, measured
from lexstack_experiments.benches.peers import child_with
from lexstack_experiments.hierarchies.peers import STRICT, installed
from lexstack_experiments.hierarchies.random_problems import with_unit_rows
from lexstack_experiments.hierarchies.recorded import Sequence
from lexstack_experiments.hierarchies.weighted import WEIGHTED

INF = np.inf


def with_endless_rows():
    """Return a problem whose first level has rows with one end, with two, and with none."""
    rng = np.random.default_rng(1)
    lower = np.array([-0.1, -INF, -INF, -0.2])
    upper = np.array([INF, 0.1, INF, 0.2])
    first = LinearTask("rows", rng.normal(size=(4, 6)), lower, upper)
    second = LinearTask.equality("to", rng.normal(size=(3, 6)), rng.normal(size=3))
    return HqpProblem(((first,), (second,)), Bounds(np.full(6, -1.0), np.full(6, 1.0)))


@pytest.mark.parametrize("peer", installed(STRICT)[0], ids=lambda peer: peer.name)
def test_no_peer_prints_a_word_about_rows_without_ends(peer, capfd):
    """Libraries write past Python: a bench of some thousand solves would flood the terminal."""
    solution = peer.solve(with_endless_rows())
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")
    assert solution.solved
    assert solution.slacks[0] < 1e-6


def regular(n=5, seed=2):
    """Return two levels that can be met together inside wide bounds."""
    rng = np.random.default_rng(seed)
    levels = tuple(
        (LinearTask.equality(f"level_{k}", rng.normal(size=(2, n)), 0.1 * rng.normal(size=2)),)
        for k in range(2)
    )
    return HqpProblem(levels, Bounds(np.full(n, -10.0), np.full(n, 10.0)))


def conflicting():
    """Return two levels that ask for different things."""
    row = np.array([[1.0, 0.0]])
    levels = [LinearTask.equality(name, row, np.array([to])) for name, to in (("a", 1.0), ("b", 0))]
    return HqpProblem(tuple((level,) for level in levels), Bounds(-np.ones(2), np.ones(2)))


@pytest.mark.parametrize("peer", installed(WEIGHTED)[0], ids=lambda peer: peer.name)
def test_weights_meet_what_can_be_met_and_give_way_where_it_cannot(peer):
    assert peer.solve(regular()).slacks.max() < 1e-3, "QP solvers of theirs, with their tolerances"
    chi = peer.solve(conflicting()).chi
    # Costs of 1 and 0.1: the sum of 1 (x - 1)^2 + 0.01 x^2 is least at 1 / 1.01.
    assert chi[0] == pytest.approx(1.0 / 1.01, abs=1e-6)


def test_libraries_with_weights_agree():
    given = regular(7, 5)
    answers = [peer.solve(given).chi for peer in installed(WEIGHTED)[0]]
    rows = given.levels[0][0].matrix
    for chi in answers[1:]:
        np.testing.assert_allclose(rows @ chi, rows @ answers[0], atol=1e-5)


def test_an_answer_that_is_not_strict_is_a_failure_of_the_bench():
    sequence = Sequence("stack", False, (conflicting(), regular()), 0.0)
    ours, weighted = Local(make_solver()), Local(installed(WEIGHTED)[0][0])
    runs = measured(sequence, [ours, weighted], 2)
    assert [runs[one.name].failures for one in (ours, weighted)] == [0, 1]
    assert (ours.strict, weighted.strict) == (True, False)
    assert runs[weighted.name].excess == pytest.approx(1.0 - 1.0 / 1.01, abs=1e-6)
    assert runs[ours.name].times.shape == (2, 2)


def test_problems_with_inequality_rows_are_not_put_to_weights():
    sequence = Sequence("stack", False, (with_endless_rows(),), 0.0)
    runs = measured(sequence, [Local(make_solver()), Local(installed(WEIGHTED)[0][0])], 1)
    assert len(runs) == 1


def test_a_peer_of_another_python_is_not_looked_for_in_ours():
    python = Path(sys.executable)
    assert child_with("no_such_module", "hqp_placo", (python,)) is None
    assert child_with("json", "hqp_placo", ()) is None
    with child_with("json", "serving", (python,)) as child:
        assert child.name == "serving"


def test_rows_of_length_one_are_another_weighting_of_the_same_demands():
    given = regular()
    unit = with_unit_rows(given)
    for (task,), (scaled,) in zip(given.levels, unit.levels, strict=True):
        np.testing.assert_allclose(np.linalg.norm(scaled.matrix, axis=1), 1.0)
        ratio = task.lower / np.linalg.norm(task.matrix, axis=1)
        np.testing.assert_allclose(scaled.lower, ratio)
