"""How lexstack reaches: the tool straight to its pose, or the joints to where the pose is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lexstack.control import Controller, make_controller
from lexstack.references import PointToPoint, References, ReferenceSchedule, Target
from lexstack.robots import Pose, Team, inverse_kinematics
from lexstack.tasks import LevelConfig, StackConfig, TaskConfig, build_stack
from lexstack.transition import TransitionConfig, TransitionOptions
from lexstack.types import RobotState, Vector


class Served:
    """A controller with one stack, tick by tick."""

    def __init__(self, team: Team, *tasks: TaskConfig) -> None:
        """Build the stack: one task on each level."""
        levels = tuple(LevelConfig((task,)) for task in tasks)
        self.team = team
        self._stacks = {"reach": build_stack(StackConfig("reach", "", levels), team)}
        self._options = TransitionOptions("reach", TransitionConfig(duration=1.0))

    def serve(self, start: Vector, goal: Pose) -> Controller:
        """Return a controller for a reach from rest: the one before knows another motion."""
        references = References((goal,), self.team.base_poses(start))
        schedule = ReferenceSchedule(references, dt=self.team.dt)
        self._controller = make_controller(self.team, self._stacks, self._options, schedule)
        self._tick = 0
        return self._controller

    def velocity(self, q: Vector, last: Vector) -> Vector:
        """Return the command of one tick."""
        state = RobotState(self._tick, self._tick * self.team.dt, q, last, q, last)
        self._tick += 1
        return self._controller.tick(state).chi


class Straight(Served):
    """The tool's pose first, the posture with what is left: closed-loop inverse kinematics."""

    def __init__(self, team: Team, parameters: Mapping[str, Any]) -> None:
        """Build the stack with these parameters of ``ee_pose``."""
        super().__init__(
            team, TaskConfig("ee_pose", parameters=dict(parameters)), TaskConfig("posture")
        )

    def begin(self, start: Vector, goal: Pose) -> None:
        """Set the target."""
        self.serve(start, goal)


class ByJoints(Served):
    """The joints to where the tool is at its pose: what limits keep a straight way from reaching.

    The posture is the quickest that ``inverse_kinematics`` finds, the way there is a
    ``PointToPoint`` as quick as the limits allow, which the task ``posture`` follows.
    """

    def __init__(self, team: Team) -> None:
        """Build the stack."""
        super().__init__(team, TaskConfig("posture", parameters={"gain": 50.0}))

    def begin(self, start: Vector, goal: Pose) -> None:
        """Find the posture and set it; where none is found the arm stays."""
        controller = self.serve(start, goal)
        end = inverse_kinematics(self.team.robots[0], goal, start)
        limits = self.team.limits
        there = start if end is None else end
        way = PointToPoint(0.0, start, there, limits.velocity, limits.acceleration)
        controller.references.add(Target(0.0, 0, posture=way))
