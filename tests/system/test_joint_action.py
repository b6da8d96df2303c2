"""FollowJointTrajectory in the running system: met, cancelled, replaced, violated, refused."""

from __future__ import annotations

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance
from rclpy.action import ActionClient
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question
from lexstack_bag.run.reader import read_run
from lexstack_interfaces.msg import TransitionStatus
from lexstack_interfaces.srv import SwitchStack
from lexstack_testing.played_run import together
from lexstack_testing.user import User
from support.runs import short_scenario
from support.scenario import team

pytestmark = pytest.mark.system
Result = FollowJointTrajectory.Result
NAME = "/robot_b/follow_joint_trajectory"
MODEL = team().robots[1]
JOINTS = MODEL.joints[MODEL.arm]
ARM = slice(13, 20)  # of robot_b in q
ARMS = """name: arms
description: the arms in their postures alone
levels:
- tasks: [{type: posture, parameters: {gain: 3.0}}]
- tasks: [{type: velocity_damping}]
"""
HELD = 3  # a joint that no task but the posture's keeps where it is


class Asker(User):
    """Sends goals, and keeps what is told of them."""

    def __init__(self, run):
        super().__init__(run)
        self.client = ActionClient(self.node, FollowJointTrajectory, NAME)
        self.feedback = []
        assert self.call(SetBool, "/sim_bridge/pause", data=False).success
        self.until(lambda: self.commands and self.client.server_is_ready())
        self.spin(0.5)

    def arm(self):
        return np.array(self.states[-1].q)[ARM]

    def switch(self, stack, text=""):
        asked = {"stack": stack, "duration": 0.5, "stack_yaml": text}
        assert self.call(SwitchStack, "/robot_a/switch_stack", **asked).accepted
        self.until_told(lambda s: s.to_stack == stack and s.phase == TransitionStatus.IDLE)

    def send(self, target, seconds, **fields):
        """Return the handle of a goal that leads to a posture in some time."""
        goal = FollowJointTrajectory.Goal(**fields)
        goal.trajectory.joint_names = list(reversed(JOINTS))
        goal.trajectory.points = [
            JointTrajectoryPoint(
                positions=list(map(float, reversed(where))), time_from_start=_duration(when)
            )
            for where, when in ((self.arm(), 0.5 * seconds), (target, seconds))
        ]
        return self.accepted(goal)

    def accepted(self, goal):
        sent = self.client.send_goal_async(goal, lambda m: self.feedback.append(m.feedback))
        self.until(sent.done, "the goal to be accepted")
        return sent.result()

    def result(self, handle):
        """Return status, code and text of a goal that has ended."""
        answer = handle.get_result_async()
        self.until(answer.done, "the result")
        found = answer.result()
        return found.status, found.result.error_code, found.result.error_string


@pytest.fixture(scope="module")
def asker(tmp_path_factory):
    scenario = short_scenario(events=(), duration=3000.0)
    with together(scenario, tmp_path_factory.mktemp("run")) as run:
        asker = Asker(run)
        asker.switch("arms", ARMS)
        yield asker


def elsewhere(asker, by=0.2):
    target = asker.arm()
    target[HELD] += by
    return target


def test_a_goal_is_met(asker):
    target = elsewhere(asker)
    status, code, text = asker.result(asker.send(target, 2.0))
    assert (status, code, text) == (GoalStatus.STATUS_SUCCEEDED, Result.SUCCESSFUL, "")
    assert np.allclose(asker.arm(), target, atol=0.021)
    assert len(asker.feedback) > 20
    told = asker.feedback[-1]
    assert told.joint_names == list(JOINTS)
    error = np.subtract(told.desired.positions, told.actual.positions)
    assert np.allclose(told.error.positions, error)
    spans = np.ptp([f.actual.positions for f in asker.feedback], axis=0)
    assert spans[HELD] > 0.15


def test_a_goal_that_is_cancelled_comes_to_rest_on_its_way(asker):
    begin, target = asker.arm(), elsewhere(asker, -0.4)
    handle = asker.send(target, 6.0)
    asker.until(lambda: asker.arm()[HELD] < begin[HELD] - 0.05, "the arm to move")
    handle.cancel_goal_async()
    status, _, text = asker.result(handle)
    assert (status, text) == (GoalStatus.STATUS_CANCELED, "cancelled")
    asker.until(lambda: np.abs(np.array(asker.states[-1].v)).max() < 1e-3, "rest")
    assert asker.arm()[HELD] > target[HELD] + 0.1


def test_another_goal_and_another_target_replace_one(asker):
    first = asker.send(elsewhere(asker), 5.0)
    second = asker.send(elsewhere(asker), 5.0)
    status, code, text = asker.result(first)
    assert (status, code) == (GoalStatus.STATUS_ABORTED, Result.INVALID_GOAL)
    assert "another goal" in text
    asker.publisher(JointTrajectory, "/robot_b/posture_trajectory").publish(JointTrajectory())
    assert "another target" in asker.result(second)[2]


def test_a_goal_that_cannot_be_ends_with_the_reason(asker):
    goal = FollowJointTrajectory.Goal()
    status, code, text = asker.result(asker.accepted(goal))
    assert (status, code) == (GoalStatus.STATUS_ABORTED, Result.INVALID_GOAL)
    assert "no points" in text
    beyond = asker.arm()
    beyond[HELD] = 3.0
    status, code, text = asker.result(asker.send(beyond, 30.0))
    assert (status, code) == (GoalStatus.STATUS_ABORTED, Result.INVALID_GOAL)
    assert f"{JOINTS[HELD]}: 3 is outside its limits" in text


def test_where_no_task_moves_the_arm_the_tolerances_say_so(asker):
    asker.switch("track")
    near = JointTolerance(name=JOINTS[HELD], position=0.05)
    status, code, text = asker.result(asker.send(elsewhere(asker), 1.0, path_tolerance=[near]))
    assert (status, code) == (GoalStatus.STATUS_ABORTED, Result.PATH_TOLERANCE_VIOLATED)
    assert f"on the way: {JOINTS[HELD]}: off by" in text
    assert "does the stack in effect have a task on the posture?" in text
    late = _duration(0.5)
    _, code, text = asker.result(asker.send(elsewhere(asker), 1.0, goal_time_tolerance=late))
    assert code == Result.GOAL_TOLERANCE_VIOLATED
    assert "at the goal" in text


def test_the_run_is_replayed_bit_for_bit(asker):
    assert asker.run.end() == []
    run = read_run(asker.run.out)
    for node in ("robot_a", "robot_b"):
        found = REPLAYERS[node](Question(run, Changes(), run.resolved))
        assert found.identical, found.line()


def _duration(seconds):
    return Duration(sec=int(seconds), nanosec=round(1e9 * (seconds % 1.0)))
