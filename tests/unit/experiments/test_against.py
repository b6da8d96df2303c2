"""A bench in another clone: who is measured when, what is compared, and what a worker says."""

import sys
from pathlib import Path

import numpy as np
import pytest

from lexstack.errors import LexstackError
from lexstack_experiments.benches.against import alternately, compared
from lexstack_experiments.benches.child import Child, in_turns, path_of
from lexstack_experiments.benches.goals import goal_of

ROOT = Path(__file__).resolve().parents[3]


def test_both_sides_take_turns_and_neither_always_begins():
    seen = []
    mine, other = alternately(3, lambda: seen.append("A") or {}, lambda: seen.append("B") or {})
    assert "".join(seen) == "ABBAAB"
    assert (len(mine), len(other)) == (3, 3)


def test_rows_that_one_side_lacks_are_left_out_and_ratios_are_by_turn():
    ours = [{"x": [1.0, 1.0], "new": [1.0]}, {"x": [10.0, 10.0], "new": [1.0]}]
    theirs = [{"x": [4.0, 4.0], "old": [1.0]}, {"x": [40.0, 40.0], "old": [1.0]}]
    (row,) = compared(ours, theirs)
    assert (row.name, row.p50, row.p99) == ("x", 0.25, 0.25)
    assert row.theirs[1] == pytest.approx(40.0)


def test_many_take_turns_in_an_order_that_changes():
    seen = []
    times = in_turns(2, {name: lambda n=name: seen.append(n) or [1.0] for name in "abc"})
    assert "".join(seen) == "abccba"
    assert {name: every.shape for name, every in times.items()} == dict.fromkeys("abc", (2, 1))


def problem():
    """Return a problem of three joints as a worker takes it: infinite ends, too."""
    rows = (np.ones((1, 3)), np.array([0.3]), np.array([np.inf]))
    return {"levels": [rows], "lower": -np.ones(3), "upper": np.ones(3)}


def test_a_worker_solves_in_this_source_tree_and_names_its_faults():
    with Child("against_hqp") as child:
        assert child.ask("load", name="row", problems=[problem(), problem()]) == 2
        assert [len(times) for times in child.ask("turn").values()] == [2]
        with pytest.raises(LexstackError, match=r"worker against_hqp: load: .*TypeError"):
            child.ask("load", name="row", problem=None)
        assert len(child.ask("turn")["row"]) == 2, "it goes on"


def test_a_worker_that_ends_is_told():
    with Child("no_such_program") as child, pytest.raises(LexstackError, match="ended with 2"):
        child.ask("turn")


def test_the_path_of_a_clone_has_all_its_packages(tmp_path):
    names = [Path(part).name for part in path_of(ROOT).split(":")]
    assert {"lexstack", "lexstack_config", "lexstack_experiments", "sim_bridge"} <= set(names)
    with pytest.raises(LexstackError, match="no clone of this project"):
        path_of(tmp_path)


def test_a_worker_with_another_python_leaves_our_packages_out():
    python = Path(sys.base_prefix) / "bin/python3"
    with Child("against_hqp", python) as child, pytest.raises(LexstackError, match="ended with 1"):
        child.ask("turn")


def test_ratios_over_an_earlier_version_have_the_goals_of_their_rows():
    name = "panda_summit, N = 20, lexstack: p99 over 7c475a2"
    assert goal_of("htmpc", name).limit == pytest.approx(1.0 / 3.0)
