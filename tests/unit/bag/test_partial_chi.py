"""Chi of some robots, as one of several solvers sends it, in a bag."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.run.partial_chi import joined, robots_of
from lexstack_bag.run.provenance import run_provenance
from lexstack_bag.run.reader import read_run
from lexstack_bag.storage.writer import BagWriter
from lexstack_config.parts import build_team

from .conftest import Maker

A, B, BOTH = ["robot_a"], ["robot_b"], ["robot_a", "robot_b"]
MINE = slice(0, 10)
THEIRS = slice(10, 20)


@pytest.fixture(scope="module")
def run(tmp_path_factory, resolved):
    """Tick 0: both parts; 1: B's alone; 2: A's twice, then B's; 3: a failed one; 4: whole.

    The parts of tick 2 arrive in between those of tick 0.
    """
    folder = tmp_path_factory.mktemp("parts") / "bag"
    with BagWriter(folder, run_provenance(resolved)) as writer:
        maker = Maker(writer, resolved)
        for tick in range(5):
            maker.plant(tick)
        for tick, robots, value in (
            (0, A, 1.0),
            (2, A, 4.0),
            (2, A, 5.0),
            (0, B, 2.0),
            (1, B, 3.0),
            (2, B, 6.0),
            (3, A, None),
            (4, BOTH, 7.0),
        ):
            n = 10 * len(robots)
            chi = np.zeros(0) if value is None else np.full(n, value)
            bounds = {"lower": np.full(n, -9.0), "upper": np.full(n, 9.0)}
            maker.put(
                "/robot_b/chi",
                "lexstack_interfaces/msg/Chi",
                stamp=tick / 100,
                tick=tick,
                sender="stack_solver@host/1/0" if robots != B else "stack_solver_2@host/2/0",
                references=1,
                robots=robots,
                stack="reach_base",
                transition_id=1,
                chi=chi,
                **bounds,
                slacks=np.zeros(2),
                status=0,
                empty_bounds=0,
                solve_time=0.0,
                reason="",
            )
    return read_run(folder)


def test_a_part_stands_at_its_joints(run):
    last, before = run.chi["robot_b"], run.replaced["robot_b"]
    assert last.tick.tolist() == [0, 1, 2, 3, 4]
    assert last.robots.tolist() == ["robot_b", "robot_b", "robot_b", "robot_a", "robot_a robot_b"]
    for tick, value in ((0, 2.0), (1, 3.0), (2, 6.0)):
        assert np.isnan(last.chi[tick, MINE]).all()
        assert (last.chi[tick, THEIRS] == value).all()
    assert np.isnan(last.chi[3]).all()
    assert (last.chi[4] == 7.0).all()
    assert before.chi[:, 0].tolist() == [1.0, 4.0, 5.0]
    assert np.isnan(before.chi[:, THEIRS]).all()
    assert (before.upper[:, MINE] == 9.0).all()
    assert np.isnan(before.upper[:, THEIRS]).all()


def test_the_parts_of_a_tick_are_joined(run):
    whole = joined(run, "robot_b")
    assert whole.chi[0].tolist() == [1.0] * 10 + [2.0] * 10
    assert np.isnan(whole.chi[1, MINE]).all(), "nobody sent it"
    assert whole.chi[2].tolist() == [5.0] * 10 + [6.0] * 10, "the later of two"
    assert np.isnan(whole.chi[3]).all()
    assert (whole.chi[4] == 7.0).all()
    assert (whole.lower[2] == -9.0).all()
    assert not whole.chi.flags.writeable


def test_a_run_of_one_solver_is_left_alone(synthetic):
    run = read_run(synthetic.folder)
    assert joined(run, "robot_b") is run.chi["robot_b"]
    assert joined(replace(run, replaced={}), "robot_a") is run.chi["robot_a"]


def test_names_of_a_row(resolved):
    team = build_team(resolved)
    assert robots_of("robot_b", team) == (1,)
    assert robots_of("robot_a robot_b", team) == (0, 1)
    assert robots_of("", team) == (0, 1), "bags of before have no names"
    assert robots_of("somebody", team) == (0, 1)
