"""Stacks that move some of the robots: read, built, cut, joined and solved."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack.errors import ConfigurationError
from lexstack.tasks import joined
from lexstack_config.available import load_stack
from lexstack_config.parts import build_references, build_stack_solver
from lexstack_config.resolved import load_scenario
from support.channels import parts, with_single_stacks
from support.scenario import CONFIG, home, random_q, state_at, team
from support.stack_files import HEAD, LEVELS, folder


def test_a_stack_moves_the_robots_that_it_names():
    stack = parts().stacks["posture_robot_b"]
    assert stack.robots == (1,)
    assert {task.robots for level in stack.levels for task in level.tasks} == {(1,)}
    assert parts().stacks["posture"].robots == (0, 1)


def test_a_stack_for_other_robots_is_left_out(tmp_path):
    path = folder(tmp_path, some=f"{HEAD}robots: [rover]\n{LEVELS}")
    assert "some" not in load_scenario(path).stacks
    assert "track" in load_scenario(path).stacks


def test_a_stack_with_limits_for_another_kind_of_robot_is_left_out(tmp_path):
    limits = "limits: {robot_a: {elbow_joint: {position: [-1.0, 1.0]}}}\n"
    path = folder(tmp_path, some=HEAD + LEVELS + limits)
    known = load_scenario(path).stacks
    assert "some" not in known
    assert "confined" in known, "it names joints of these robots"
    others = load_scenario(CONFIG / "scenarios/delivery.yaml").stacks
    assert "confined" not in others
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("initial_stack: track", "initial_stack: some"), encoding="utf-8")
    assert "some" in load_scenario(path).stacks, "what is asked for is not left out in silence"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("initial_stack: track", "stack 'some' names robots that the scenario has not: rover"),
        ("switch: track", "stack 'some' names robots that the scenario has not: rover"),
    ],
)
def test_a_scenario_that_wants_such_a_stack_is_refused(tmp_path, line, message):
    path = folder(tmp_path, some=f"{HEAD}robots: [rover]\n{LEVELS}")
    text = path.read_text(encoding="utf-8")
    assert line in text
    path.write_text(text.replace(line, line.replace("track", "some")), encoding="utf-8")
    with pytest.raises(ConfigurationError, match=message):
        load_scenario(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("robots: [robot_a, robot_a]\n" + LEVELS, "robots: 'robot_a' stands in it twice"),
        (
            "robots: [robot_a]\n" + LEVELS + "        robot: robot_b\n",
            "robots: 'robot_b' is named by a task or limit, but not here: robot_a",
        ),
        (
            (
                "robots: [robot_a]\nlevels:\n  - tasks:\n      - type: relative_pose\n"
                "        robot: robot_a\n        parameters: {other: robot_b}\n"
            ),
            "'robot_b' is named by a task",
        ),
    ],
)
def test_a_stack_that_contradicts_itself_is_refused(tmp_path, text, message):
    path = folder(tmp_path, some=HEAD + text)
    with pytest.raises(ConfigurationError, match=message):
        load_stack(path.parent.parent / "stacks" / "some.yaml")
    assert message in load_scenario(path).unfit["some"]


def test_the_initial_stack_moves_all_robots():
    base = with_single_stacks()
    wrong = replace(base, scenario=replace(base.scenario, initial_stack="track_robot_a"))
    with pytest.raises(ConfigurationError, match="'track_robot_a' leaves robot_b without a stack"):
        wrong.validate("here")


def test_a_stack_is_cut_and_joined_level_by_level():
    stack = parts().stacks["posture"]
    one, other = stack.of((0,)), stack.of((1,))
    assert one.name == other.name == "posture"
    whole = joined([one, other])
    assert whole.name == "posture"
    assert whole.robots == (0, 1)
    for cut, level in zip(whole.levels, stack.levels, strict=True):
        assert sorted(task.name for task in cut.tasks) == sorted(task.name for task in level.tasks)
    assert joined([one, parts().stacks["track_robot_b"]]).name == "posture + track_robot_b"


def test_what_couples_robots_is_found():
    assert parts().stacks["carry"].coupling((1,)) == "robot_a/relative_pose"
    assert parts().stacks["carry"].coupling((0, 1)) == ""
    assert parts().stacks["posture"].coupling((1,)) == ""


@pytest.mark.parametrize("seed", range(5))
def test_a_part_of_a_stack_has_the_whole_ones_optimum(seed):
    rng = np.random.default_rng(seed)
    solver = build_stack_solver(with_single_stacks(), parts())
    q = home() + 0.3 * (random_q(rng) - home())
    kinematics = team().kinematics(state_at(q))
    references = build_references(with_single_stacks(), team()).at(0.0)
    whole = solver.solve("reach_base", kinematics, references).chi
    for robot, name in enumerate(team().names):
        chi = solver.solve(f"reach_base_{name}", kinematics, references).chi
        part = team().slices[robot]
        np.testing.assert_allclose(chi[part], whole[part], atol=1e-8)
        assert not np.delete(chi, np.r_[part]).any(), "the others are at rest"
