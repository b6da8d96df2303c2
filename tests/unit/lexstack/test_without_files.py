"""The library by hand: robots, stacks and parameters without a file."""

import numpy as np
import pytest

import lexstack
from lexstack_config.resolved import load_htmpc
from support.scenario import CONFIG, home, state_at, team

PANDA = "panda_description/urdf/panda.urdf"
HOME = (0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79)


def test_a_robot_from_its_urdf_has_the_urdf_s_limits():
    made = lexstack.RobotModel("panda", lexstack.mobile_manipulator(PANDA, "panda_hand", HOME))
    known = team().robots[0].limits
    assert made.joints == team().robots[0].joints
    assert (made.limits.position_lower == known.position_lower).all()
    assert (made.limits.position_upper == known.position_upper).all()
    assert (made.limits.velocity[3:] == known.velocity[3:]).all()
    assert made.home((1.0, 2.0, 0.5)).tolist() == [1.0, 2.0, 0.5, *HOME]


@pytest.mark.parametrize(
    ("description", "tool", "angles", "error", "text"),
    [
        ("no.urdf", "panda_hand", HOME, lexstack.ModelError, "no file 'no.urdf'"),
        (PANDA, "nothing", HOME, lexstack.ModelError, "no link 'nothing'"),
        (PANDA, "panda_hand", (), lexstack.ModelError, "has 9 joints, got 0"),
        (PANDA, "panda_hand", (0.0,) * 10, lexstack.ModelError, "has 9 joints, got 10"),
        (PANDA, "panda_hand", (0.0,) * 7, lexstack.ConfigurationError, "panda_joint4: home"),
    ],
)
def test_what_cannot_be_a_robot_is_refused(description, tool, angles, error, text):
    with pytest.raises(error, match=text):
        lexstack.RobotModel("x", lexstack.mobile_manipulator(description, tool, angles))


def test_the_default_parameters_are_those_of_the_file():
    assert load_htmpc(CONFIG / "htmpc" / "lexstack.yaml") == lexstack.DEFAULT_HTMPC


def test_a_stack_of_tasks_has_one_a_level_for_every_robot():
    stack = lexstack.build_stack(lexstack.StackConfig.of_tasks("s", "ee_pose", "posture"), team())
    names = [[task.name for task in level.tasks] for level in stack.levels]
    assert names == [["robot_a/ee_pose", "robot_b/ee_pose"], ["robot_a/posture", "robot_b/posture"]]


def test_an_exact_plant_s_next_state():
    first = lexstack.RobotState.at_rest(home())
    chi = np.arange(20.0)
    then = first.after(chi, 0.01).after(chi, 0.01)
    assert (then.tick, then.stamp) == (2, 0.02)
    np.testing.assert_allclose(then.q, home() + 0.02 * chi)
    assert (then.command == chi).all()
    assert (then.q_star == then.q).all()


def test_a_source_answers_what_was_announced():
    config = lexstack.StackConfig.of_tasks("s", "ee_pose", "velocity_damping")
    stacks = {"s": lexstack.build_stack(config, team())}
    source = lexstack.make_stack_solver(team(), stacks)
    state = state_at(home(), tick=7)
    references = lexstack.ReferenceSchedule.at_home(team(), home() + 0.01).at(0.07)
    wanted = lexstack.Announcement(3, "s", 7, active=True)
    sample = source.answer(wanted, team().kinematics(state), references)
    assert (sample.transition_id, sample.tick, sample.solved) == (3, 7, True)
    assert sample.revision == references.revision == 1
    same = lexstack.make_stack_solver(team(), stacks).solve(
        "s", team().kinematics(state), references
    )
    assert (sample.chi == same.chi).all()
    assert sample.slack == same.slacks[0]


def test_references_by_name_hold_and_the_others_follow_the_robots():
    place = np.array([0.5, 0.0, 0.1])
    schedule = lexstack.ReferenceSchedule.at_home(team(), home(), base={"robot_b": place})
    elsewhere = team().home({"robot_a": (3.0, 0.0, 0.0)})
    schedule.begin(lexstack.References(team().tools(elsewhere), (elsewhere[:3], elsewhere[10:13])))
    first = schedule.at(0.0)
    assert first.base[1].tolist() == place.tolist()
    assert first.base[0].tolist() == [3.0, 0.0, 0.0]


def test_a_number_that_is_none_says_what_stood_there():
    from lexstack.options import build
    from lexstack_config.reader import build as from_yaml

    with pytest.raises(lexstack.ConfigurationError, match=r"expected float, got '1e3'$") as caught:
        build(lexstack.TransitionConfig, {"duration": "1e3"}, "here")
    assert caught.value.found == "1e3"
    with pytest.raises(lexstack.ConfigurationError, match=r"YAML reads as text: write 1.0e\+3"):
        from_yaml(lexstack.TransitionConfig, {"duration": "1e3"}, "here")
