"""What the page shows of messages."""

from __future__ import annotations

import numpy as np
import pytest
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lexstack.errors import InputError
from lexstack.types import PlantStatus
from lexstack_config.parts import build_references
from lexstack_interfaces.msg import Chi, PlantState, SequenceStatus, TransitionStatus
from lexstack_ros.messages.plans import joint_names
from lexstack_ros.view.heard import Heard, horizon_of, picture_of
from support.scenario import home, resolved, team


def told(*statuses, chi=None, tick=200, **fields):
    state = PlantState(tick=tick, q=home().tolist(), **fields)
    state.header.stamp.sec = 2
    references = build_references(resolved(), team()).at(2.0)
    return picture_of(team(), Heard(state, statuses, chi or {}), references, references)


def status(phase, *robots):
    return TransitionStatus(
        phase=phase, from_stack="track", to_stack="posture", alpha=0.25, robots=robots
    )


@pytest.mark.parametrize(
    ("phase", "stack", "word"),
    [
        (TransitionStatus.IDLE, "posture", "idle"),
        (TransitionStatus.REQUESTED, "track, then posture", "requested"),
        (TransitionStatus.PREPARING, "track, then posture", "preparing"),
        (TransitionStatus.BLENDING, "track → posture", "blending"),
        (TransitionStatus.ADOPTING, "posture", "adopting"),
    ],
)
def test_the_stack_in_effect_is_named(phase, stack, word):
    picture = told(status(phase))
    assert (picture.stack, picture.phase, picture.alpha) == (stack, word, 0.25)


def test_transitions_of_several_robots_are_told_apart():
    idle = status(TransitionStatus.IDLE, "robot_a")
    busy = status(TransitionStatus.BLENDING, "robot_b")
    picture = told(idle, busy)
    assert picture.stack == "posture (robot_a); track → posture (robot_b)"
    assert picture.phase == "blending"
    assert told(status(TransitionStatus.IDLE, "robot_a", "robot_b")).stack == "posture"


def test_before_anything_is_known_it_says_so_without_failing():
    picture = told()
    assert (picture.tick, picture.time, picture.levels, picture.solve) == (200, 2.0, (), {})
    assert np.array_equal(picture.q, home())
    assert picture.plant == PlantStatus.FOLLOWING


def test_solve_times_are_in_milliseconds_and_old_ones_are_left_out():
    chi = {
        "robot_a": Chi(tick=200, solve_time=0.0005, slacks=[0.1, float("nan")]),
        "robot_b": Chi(tick=150, solve_time=0.0004),
    }
    picture = told(chi=chi)
    assert picture.solve["robot_a"] == pytest.approx(0.5)
    assert np.isnan(picture.solve["robot_b"])
    assert picture.levels == (0.1, 0.0)


@pytest.mark.parametrize(
    ("statuses", "fields", "field"),
    [
        ((), {"status": 77}, "/plant/state: status"),
        ((status(99),), {}, "/robot_a/transition: phase"),
    ],
)
def test_a_number_that_stands_for_nothing_is_refused(statuses, fields, field):
    with pytest.raises(InputError, match=field):
        told(*statuses, **fields)


def test_a_state_of_other_robots_is_refused():
    references = build_references(resolved(), team()).at(0.0)
    with pytest.raises(InputError, match="/plant/state: q"):
        picture_of(team(), Heard(PlantState(q=[0.0])), references, references)


def plan(robot, points):
    joints = joint_names(team(), robot)
    message = JointTrajectory(joint_names=joints)
    message.points = [JointTrajectoryPoint(positions=list(map(float, q))) for q in points]
    return message


def test_a_horizon_is_the_path_of_the_tool():
    part = team().slices[1]
    points = [home()[part] + 0.1 * k for k in range(3)]
    robot, path = horizon_of(plan(1, points), team())
    assert robot == 1
    tools = [team().robots[1].tool(q)[0].position for q in points]
    assert np.allclose(path, tools)


def test_a_plan_that_does_not_fit_is_refused():
    with pytest.raises(InputError, match="joint_names"):
        horizon_of(JointTrajectory(joint_names=["x"]), team())
    with pytest.raises(InputError, match=r"points\[0\].positions"):
        horizon_of(plan(0, [[1.0]]), team())


def test_what_the_mpc_works_on_is_told_in_words():
    heard = Heard(
        PlantState(q=home().tolist()),
        progress=(
            SequenceStatus(robot="robot_a", index=1, count=3, task="cup", error=0.25),
            SequenceStatus(robot="robot_b", index=2, count=2),
        ),
    )
    references = build_references(resolved(), team()).at(0.0)
    assert picture_of(team(), heard, references, references).sequences == (
        "robot_a: task 2 of 3: cup, 250 mm away, 0 ms",
        "robot_b: all 2 tasks are done",
    )
