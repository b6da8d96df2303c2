"""Plans and sequences between messages and library: what goes in comes out, the rest is refused."""

import dataclasses

import numpy as np
import pytest
from geometry_msgs.msg import Pose
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.errors import InputError
from lexstack.mpc import Plan, SequenceTask
from lexstack_interfaces.msg import SequenceTask as TaskMessage
from lexstack_ros.messages.plans import (
    joint_names,
    plan_message,
    task_message,
    to_plan,
    to_points,
    to_task,
    to_tasks,
)
from support.scenario import team

RATE = 100.0


def made(stamp=0.25):
    rng = np.random.default_rng(0)
    u = rng.standard_normal((10, 10))
    v = np.vstack((np.zeros(10), np.cumsum(0.1 * u, axis=0)))
    return Plan(stamp, 0.1, np.zeros((11, 10)), v, u, (), (), (), 0.0)


def message(robot=1):
    return plan_message(made(), joint_names(team(), robot))


def test_a_plan_is_sampled_as_its_message_says():
    heard = to_plan(message(), team(), RATE)
    assert (heard.robot, heard.tick) == (1, 25)
    for elapsed in np.linspace(0.0, 1.0, 37):
        assert np.allclose(heard.at(elapsed), made().sample(0.25 + elapsed)[1], atol=1e-12)
    assert heard.at(1.01) is None


def test_a_plan_of_a_differential_base_has_positions_of_its_arm_alone():
    u = np.zeros((2, 4))
    q = np.arange(15.0).reshape(3, 5)
    plan = Plan(0.0, 0.1, q, np.ones((3, 4)), u, (), (), (), 0.0)
    told = plan_message(plan, ["v", "w", "one", "two"])
    assert [list(point.positions) for point in told.points] == [[0, 0, *row[3:]] for row in q]
    assert list(told.points[1].velocities) == [1.0] * 4


def broken(**changes):
    def change(plan):
        for key, value in changes.items():
            setattr(plan, key, value)

    return change


def point(index, **changes):
    def change(plan):
        for key, value in changes.items():
            setattr(plan.points[index], key, value)

    return change


def stamp_between_ticks(plan):
    plan.header.stamp.nanosec = 253_000_000


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (broken(joint_names=["x"]), "joint_names"),
        (broken(joint_names=joint_names(team(), 0)[::-1]), "joint_names"),
        (broken(points=[]), "points: expected 2 to"),
        (point(3, velocities=[0.0] * 9), r"points\[3\].velocities: expected 10"),
        (point(3, velocities=[float("nan")] * 10), r"points\[3\].velocities"),
        (point(3, velocities=[1e9] * 10), r"points\[3\].velocities.*out of range"),
        (lambda plan: plan.points.reverse(), "time_from_start"),
        (stamp_between_ticks, "not the stamp of a tick"),
    ],
)
def test_a_plan_that_does_not_fit_is_refused(change, text):
    plan = message()
    change(plan)
    with pytest.raises(InputError, match=text):
        to_plan(plan, team(), RATE)


COORDINATE = st.floats(-5.0, 5.0)
KINDS = {
    "ee_position": 3,
    "ee_pose": 7,
    "ee_orientation": 4,
    "base_position": 2,
    "base_pose": 3,
    "joint_positions": 2,
}


@st.composite
def tasks(draw):
    kind = draw(st.sampled_from(sorted(KINDS)))
    point = [draw(COORDINATE) for _ in range(KINDS[kind])]
    if kind in ("ee_pose", "ee_orientation"):
        point[-4:] = [0.0, 0.6, 0.0, 0.8]
    if kind == "base_pose":
        point[2] = draw(st.floats(-3.1, 3.1))
    return SequenceTask(
        draw(st.text("abc #1", min_size=1, max_size=8)),
        kind,
        (tuple(point),),
        draw(st.one_of(st.none(), st.floats(0.1, 2.0))),
        None,
        draw(st.floats(0.001, 1.0)),
        draw(st.floats(0.001, 1.0)),
        draw(st.floats(0.0, 5.0)),
        draw(st.booleans()),
        draw(st.sampled_from(["tool", "left"])) if kind.startswith("ee") else "tool",
        draw(st.sampled_from([(), ("a", "b")])) if kind == "joint_positions" else (),
    )


@settings(max_examples=60, derandomize=True, deadline=None)
@given(task=tasks())
def test_a_task_comes_back_as_it_was(task):
    back = to_task(task_message(task), "goal")
    assert np.allclose(back.points, task.points, atol=1e-12)
    assert dataclasses.replace(back, points=task.points) == task


@pytest.mark.parametrize(
    ("field", "value", "text"),
    [
        ("name", "", "name"),
        ("name", "x" * 200, "name"),
        ("kind", "tail", "kind: 'tail' is not one of"),
        ("points", [], "points: expected 1 to"),
        ("speed", -1.0, "speed: must be >= 0"),
        ("dwell", float("inf"), "finite"),
        ("tolerance", float("nan"), "finite"),
    ],
)
def test_a_task_that_cannot_be_is_refused(field, value, text):
    task = task_message(SequenceTask("give", "ee_position", ((1.0, 0.0, 1.0),)))
    setattr(task, field, value)
    with pytest.raises(InputError, match=text):
        to_task(task, "goal")


@pytest.mark.parametrize(
    ("positions", "joints", "text"),
    [
        ([], [], "positions: expected one per joint and point, got 0 for 2 points"),
        ([1.0, 2.0, 3.0], [], "positions: expected one per joint and point, got 3 for 2 points"),
        ([1.0, 2.0], ["a", "b"], "positions: expected one per joint and point, got 2 for 2 points"),
        ([1.0, float("nan")], [], "positions"),
    ],
)
def test_positions_of_joints_that_do_not_fit_are_refused(positions, joints, text):
    message = TaskMessage(name="t", kind="joint_positions", points=[Pose(), Pose()])
    message.positions, message.joints = positions, joints
    with pytest.raises(InputError, match=f"goal: {text}"):
        to_task(message, "goal")


def test_zero_stands_for_the_default_tolerances():
    task = TaskMessage(name="give", kind="base_position", points=[Pose()])
    assert (to_task(task, "goal").tolerance, to_task(task, "goal").tolerance_angle) == (0.02, 0.1)


def test_a_goal_without_tasks_is_refused():
    with pytest.raises(InputError, match="tasks: expected 1 to"):
        to_tasks([], "goal")


def test_points_that_are_not_finite_are_refused():
    pose = Pose()
    pose.position.x = float("inf")
    with pytest.raises(InputError, match=r"points\[0\]"):
        to_points(TaskMessage(points=[pose]), "base_position", "task")
