"""/NAME/follow_joint_trajectory: postures by the action that MoveIt and others use.

It is there where control_msgs is. A goal becomes the reference of the arm, as a message on
/NAME/posture_trajectory does; the robot follows it while the stack has a task on the posture.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

from lexstack.errors import InputError
from lexstack.robots import Team
from lexstack.types import RobotState, Vector
from lexstack_ros.controller.joint_goals import INVALID_GOAL, SUCCESSFUL, GoalError, JointGoal
from lexstack_ros.controller.target_topics import TargetTopics
from lexstack_ros.messages.conversions import to_array, to_time
from lexstack_ros.node.goal_server import GoalServer

NAME = "follow_joint_trajectory"
_FEEDBACK = 0.05  # s of simulated time between two messages
_HINT = "does the stack in effect have a task on the posture?"


@dataclass
class _Running:
    """A goal under way: the server's, what it asks for, and when it was last told of [s]."""

    handle: ServerGoalHandle
    goal: JointGoal
    told: float = -np.inf


class FollowJointTrajectory:
    """The servers of all arms; none where control_msgs is missing."""

    def __init__(self, node: Node, team: Team, targets: TargetTopics) -> None:
        """Serve from now on; goals go to ``targets``."""
        self._node, self._team, self._targets = node, team, targets
        self._running: dict[int, _Running] = {}
        self._results: dict[bytes, Any] = {}
        self._servers: dict[int, GoalServer] = {}
        self._action = action_type()
        if self._action is None:
            return
        targets.on_posture = partial(self._end, code=INVALID_GOAL, why="another target has come")
        for robot, model in enumerate(team.robots):
            if len(model.joints[model.arm]):
                self._servers[robot] = GoalServer(
                    node,
                    self._action,
                    f"{model.name}/{NAME}",
                    execute_callback=self._result,
                    goal_callback=lambda _goal: GoalResponse.ACCEPT,
                    handle_accepted_callback=partial(self._begin, robot),
                    cancel_callback=lambda _goal: CancelResponse.ACCEPT,
                )

    def see(self, state: RobotState) -> None:
        """Look whether goals are met at a state."""
        for robot, running in list(self._running.items()):
            if running.handle.is_cancel_requested:
                self._targets.hold_posture(robot)
                self._end(robot, SUCCESSFUL, "cancelled")
                continue
            desired, actual = self._desired(robot, state), self._actual(robot, state)
            try:
                if running.goal.met(state.stamp, desired, actual):
                    self._end(robot, SUCCESSFUL, "")
                elif state.stamp - running.told >= _FEEDBACK:
                    running.told = state.stamp
                    running.handle.publish_feedback(
                        self._feedback(running.goal, state.stamp, desired, actual)
                    )
            except GoalError as error:
                self._targets.hold_posture(robot)
                self._end(robot, error.code, f"{error}; {_HINT}")

    def restart(self) -> None:
        """End all goals: the plant begins from its start."""
        for robot in list(self._running):
            self._end(robot, INVALID_GOAL, "the plant was reset")

    def _begin(self, robot: int, handle: ServerGoalHandle) -> None:
        """Begin with a goal, or end it at once with the reason: a rejection has no room for one."""
        handle.execute()
        model = self._team.robots[robot]
        try:
            goal = JointGoal.of(handle.request, model, self._targets.schedule.next)
            where = f"/{model.name}/{NAME}"
            self._targets.take_posture(robot, handle.request.trajectory, where)
        except InputError as error:
            code = error.code if isinstance(error, GoalError) else INVALID_GOAL
            self._node.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)
            self._finish(robot, handle, handle.abort, code, str(error))
            return
        self._end(robot, INVALID_GOAL, "pre-empted by another goal")
        self._running[robot] = _Running(handle, goal)

    def _end(self, robot: int, code: int, why: str) -> None:
        """Send the result of the goal under way, if there is one."""
        running = self._running.pop(robot, None)
        if running is None:
            return
        handle = running.handle
        if code != SUCCESSFUL:
            how = handle.abort
        else:
            how = handle.canceled if handle.is_cancel_requested else handle.succeed
        self._finish(robot, handle, how, code, why)

    def _finish(
        self, robot: int, handle: ServerGoalHandle, how: Callable[[], None], code: int, why: str
    ) -> None:
        """End a goal and send its result."""
        how()
        result = self._action.Result(error_code=code, error_string=why)
        self._results[bytes(handle.goal_id.uuid)] = result
        self._servers[robot].finish(handle)

    def _result(self, handle: ServerGoalHandle) -> Any:
        """Return the result of a goal that has ended."""
        return self._results.pop(bytes(handle.goal_id.uuid))

    def _desired(self, robot: int, state: RobotState) -> tuple[Vector, Vector]:
        """Return positions and velocities of the reference; the actual ones before it begins."""
        motion = self._targets.schedule.timeline.at(state.stamp).motion
        q, _ = self._actual(robot, state)
        rate = motion.posture_rates.get(robot)
        return motion.postures.get(robot, q), np.zeros(len(q)) if rate is None else rate

    def _actual(self, robot: int, state: RobotState) -> tuple[Vector, Vector]:
        """Return the measured positions and velocities of an arm, shape (n,) each."""
        n = len(self._team.robots[robot].mid_range)
        q, v = state.q[self._team.q_slices[robot]], state.v[self._team.slices[robot]]
        return q[-n:], v[-n:]

    def _feedback(
        self,
        goal: JointGoal,
        stamp: float,
        desired: tuple[Vector, Vector],
        actual: tuple[Vector, Vector],
    ) -> Any:
        """Return where the arm is, and where its reference is."""
        error = desired[0] - actual[0], desired[1] - actual[1]
        message = self._action.Feedback(joint_names=list(goal.joints))
        message.header.stamp = to_time(stamp)
        for field, (q, v) in (("desired", desired), ("actual", actual), ("error", error)):
            point = JointTrajectoryPoint(positions=to_array(q), velocities=to_array(v))
            point.time_from_start = _duration(stamp - goal.begin)
            setattr(message, field, point)
        return message


def _duration(seconds: float) -> Duration:
    """Return a duration [s], 0 for a negative one."""
    time = to_time(max(seconds, 0.0))
    return Duration(sec=time.sec, nanosec=time.nanosec)


def action_type() -> Any:
    """Return the action's type, or None where control_msgs is not installed."""
    try:
        from control_msgs.action import FollowJointTrajectory as Action  # noqa: PLC0415
    except ImportError:
        return None
    return Action
