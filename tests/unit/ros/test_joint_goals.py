"""Goals of FollowJointTrajectory: what may be asked for, and when one is met."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from ament_index_python.packages import get_package_share_directory
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory as Action
from control_msgs.msg import JointComponentTolerance, JointTolerance
from trajectory_msgs.msg import JointTrajectoryPoint, MultiDOFJointTrajectoryPoint

from lexstack_ros.controller.follow_joint_trajectory import FollowJointTrajectory
from lexstack_ros.controller.joint_goals import GoalError, JointGoal
from support.scenario import team

Result = Action.Result
MODEL = team().robots[0]
JOINTS = MODEL.joints[MODEL.arm]
LAST = np.linspace(0.1, 0.7, 7)
STILL = np.zeros(7)
END = 7.0  # s: now is 5, the trajectory takes 2


def goal(**fields):
    message = Action.Goal(**fields)
    message.trajectory.joint_names = list(reversed(JOINTS))
    positions = LAST[::-1].tolist()
    message.trajectory.points = [
        JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=2))
    ]
    return message


def read(message, now=5.0):
    return JointGoal.of(message, MODEL, now)


def code_of(message, now=5.0):
    with pytest.raises(GoalError) as error:
        read(message, now)
    return error.value.code, str(error.value)


def tolerance(joint=0, **fields):
    return [JointTolerance(name=JOINTS[joint], **fields)]


def test_joints_come_in_any_order():
    found = read(goal())
    assert np.array_equal(found.last, LAST)
    assert (found.begin, found.end) == (5.0, END)


def test_a_stamp_says_when_it_begins():
    message = goal()
    message.trajectory.header.stamp.sec = 6
    assert (read(message).begin, read(message).end) == (6.0, 8.0)
    message.trajectory.header.stamp.sec = 3
    assert code_of(message)[0] == Result.OLD_HEADER_TIMESTAMP
    message.trajectory.header.stamp.sec = 4
    assert read(message).end == 6.0, "it is joined on its way"


def wrong():
    empty = goal()
    empty.trajectory.points = []
    yield "no points", empty, Result.INVALID_GOAL
    for name in ("nonsense", JOINTS[1]):
        other = goal()
        other.trajectory.joint_names[0] = name
        yield f"joint {name}", other, Result.INVALID_JOINTS
    short = goal()
    short.trajectory.points[0].positions = [0.0]
    yield "one position", short, Result.INVALID_GOAL
    several = goal()
    several.multi_dof_trajectory.points = [MultiDOFJointTrajectoryPoint()]
    yield "multi dof", several, Result.INVALID_GOAL
    component = [JointComponentTolerance()]
    yield "component", goal(component_path_tolerance=component), Result.INVALID_GOAL
    foreign = [JointTolerance(name="nonsense", position=1.0)]
    yield "foreign path", goal(path_tolerance=foreign), Result.INVALID_JOINTS
    yield "foreign goal", goal(goal_tolerance=foreign), Result.INVALID_JOINTS
    yield "nan", goal(path_tolerance=tolerance(position=float("nan"))), Result.INVALID_GOAL


@pytest.mark.parametrize(
    ("message", "code"), [case[1:] for case in wrong()], ids=[case[0] for case in wrong()]
)
def test_what_cannot_be_is_refused_with_a_code(message, code):
    found, text = code_of(message)
    assert found == code
    assert text


def met(found, stamp, q=LAST, v=STILL, desired=LAST, rate=STILL):
    return found.met(stamp, (desired, rate), (q, v))


def test_it_is_met_at_the_end_and_not_before():
    found = read(goal())
    assert not met(found, 6.99)
    assert met(found, END)


@pytest.mark.parametrize(
    ("fields", "off", "text"),
    [
        ({"position": 0.1}, {"q": LAST + 0.2}, "off by 0.2, at most 0.1"),
        ({"velocity": 0.1}, {"v": STILL + 0.2}, "velocity off by 0.2, at most 0.1"),
    ],
)
def test_a_path_tolerance_counts_on_the_way_alone(fields, off, text):
    found = read(goal(path_tolerance=tolerance(3, **fields)))
    assert not met(found, 6.0)
    with pytest.raises(GoalError, match=text) as error:
        met(found, 6.0, **off)
    assert error.value.code == Result.PATH_TOLERANCE_VIOLATED
    assert JOINTS[3] in str(error.value)
    assert not met(found, 4.0, **off), "before it begins"
    assert not met(found, END, q=LAST + 0.2), "the goal has patience"


def test_a_goal_has_patience_until_it_is_near():
    found = read(goal(goal_tolerance=tolerance(2, position=0.1), goal_time_tolerance=_s(1)))
    away = LAST.copy()
    away[2] += 0.11
    assert not met(found, END, q=away)
    assert not met(found, END + 1.0, q=away)
    with pytest.raises(GoalError, match=rf"{JOINTS[2]}: off by 0.11") as error:
        met(found, END + 1.01, q=away)
    assert error.value.code == Result.GOAL_TOLERANCE_VIOLATED
    away[2] -= 0.02
    assert met(found, END + 0.5, q=away)


def test_what_a_goal_does_not_say_has_a_default_and_negative_is_without_limit():
    found = read(goal())
    assert not met(found, 6.0, q=LAST + 1.0), "no tolerance on the way"
    assert not met(found, END, q=LAST + 0.03)
    assert met(found, END, q=LAST + 0.01)
    everywhere = [JointTolerance(name=name, position=-1.0) for name in JOINTS]
    assert met(read(goal(goal_tolerance=everywhere)), END, q=LAST + 3.0)
    assert not met(read(goal(goal_time_tolerance=_s(-1))), END + 1e6, q=LAST + 1.0)


def test_the_robots_name_may_stand_before_a_joint():
    message = goal(path_tolerance=tolerance(position=0.1))
    message.path_tolerance[0].name = f"{MODEL.name}/{JOINTS[0]}"
    message.trajectory.joint_names = [f"{MODEL.name}/{n}" for n in message.trajectory.joint_names]
    assert read(message).path.position[0] == 0.1


def test_without_control_msgs_nothing_is_served(monkeypatch):
    monkeypatch.setitem(sys.modules, "control_msgs.action", None)
    served = FollowJointTrajectory(None, team(), None)  # neither is asked for anything
    served.see(None)
    served.restart()
    assert not served._servers


def test_the_types_are_those_of_jazzy():
    """Where ROS comes from wheels they are built here: with other hashes nobody is understood."""
    share = Path(get_package_share_directory("control_msgs"))
    found = {}
    for file in share.glob("*/*.json"):
        for entry in json.loads(file.read_text(encoding="utf-8"))["type_hashes"]:
            found[entry["type_name"].removeprefix("control_msgs/")] = entry["hash_string"]
    action = "action/FollowJointTrajectory"
    for name, start in {
        "msg/JointTolerance": "c254f9cece0f3b73",
        "msg/JointComponentTolerance": "739ea7566931944d",
        action: "738ebcb7a2d7cfa4",
        f"{action}_Goal": "8a9060704b269608",
        f"{action}_Result": "8002e99ed2c14c6f",
        f"{action}_Feedback": "3fd0aaecf7172512",
    }.items():
        assert found[name].startswith(f"RIHS01_{start}"), name


def _s(seconds):
    return Duration(sec=seconds)
