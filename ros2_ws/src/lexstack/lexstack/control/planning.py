"""The lexicographic MPC as a program calls it: a configuration and goals in, a plan out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import lexstack.mpc
from lexstack.errors import InputError, ModelError
from lexstack.mpc import (
    DEFAULT_HTMPC,
    CollisionScene,
    HtmpcConfig,
    Kind,
    Objective,
    Plan,
    SequenceTask,
    Start,
)
from lexstack.robots import Configuration, Pose, Robot, RobotModel, to_quaternion
from lexstack.tasks.specs.goals import is_motion, numbers, pose_from, shape_of
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, eq=False)
class Track:
    """A goal of the MPC: one level, H(7).

    Attributes:
        kind: what is led, see ``Objective``.
        frame: of the robot; empty for the base.
        goal: numbers as ``Objective`` has them in a row, or a trajectory.
    """

    kind: Kind
    frame: str
    goal: Any

    @property
    def name(self) -> str:
        """What the plan's levels call it."""
        return self.kind + (f"({self.frame})" if self.frame else "")

    def reference(self, times: Vector) -> Matrix:
        """Return the goal at times [s], shape (N, r)."""
        if not is_motion(self.goal):
            return np.tile(self.goal, (len(times), 1))
        return np.array([_row(self.goal.at(float(time))) for time in times])

    def task(self, name: str, **options: Any) -> SequenceTask:
        """Return it as a task of a sequence; ``options`` are those of ``SequenceTask``."""
        if is_motion(self.goal):
            raise InputError(f"task {name!r}: a sequence leads through points, not a trajectory")
        return SequenceTask(name, self.kind, (tuple(self.goal.tolist()),), **options)


def track(frame: str, goal: Any) -> Track:
    """Return the goal that leads a frame to a position, or to a pose.

    Args:
        frame: of the robot's default tool: its link, or ``tool``.
        goal: a position (3,) [m], a pose in any form that ``FramePose`` takes, or a trajectory of
            poses over the time of the configuration; world frame.

    Raises:
        InputError: the goal has another form.
    """
    where = f"track({frame!r})"
    if is_motion(goal):
        return Track("ee_pose", frame, goal)
    if shape_of(goal) == (3,):
        return Track("ee_position", frame, numbers(goal, (3,), where))
    return Track("ee_pose", frame, _row(pose_from(goal, where)))


def track_base(goal: Any) -> Track:
    """Return the goal that leads the base to x, y [m], or to x, y, yaw [m, m, rad].

    Args:
        goal: two or three numbers, or a trajectory of three; world frame.

    Raises:
        InputError: the goal has another form.
    """
    if is_motion(goal):
        return Track("base_pose", "", goal)
    size = 3 if shape_of(goal) == (3,) else 2
    kind: Kind = "base_pose" if size == 3 else "base_position"
    return Track(kind, "", numbers(goal, (size,), "track_base"))


class Htmpc:
    """Model predictive control of tasks in a strict order, Algorithm 2 of H, for one robot.

    Attributes:
        optimiser: what solves it.
    """

    def __init__(
        self,
        robot: Robot | RobotModel,
        config: HtmpcConfig = DEFAULT_HTMPC,
        spheres: tuple[int, ...] | None = None,
    ) -> None:
        """Generate the code of the optimiser, which takes a moment.

        Args:
            robot: that is to move.
            config: weights, horizon and limits.
            spheres: places of the spheres that keep distances; None: all.

        Raises:
            ModelError: the robot has no base, or a joint or a sphere that cannot be.
        """
        model = robot.model if isinstance(robot, Robot) else robot
        self.optimiser = lexstack.mpc.Htmpc(model, config, spheres)

    def solve(
        self,
        start: Configuration | Start,
        objectives: Sequence[Track | Objective],
        before: Plan | None = None,
        around: CollisionScene | None = None,
    ) -> Plan:
        """Return the motion over the horizon that serves the goals in their order.

        Args:
            start: where the robot is; without a velocity it is at rest.
            objectives: the most important one first, by ``track`` and ``track_base``.
            before: the plan until now: a first guess.
            around: what is in the way.

        Raises:
            InputError: a goal does not fit the robot; what a solver does is in the plan.
        """
        if isinstance(start, Configuration):
            start = Start(start.time, start.q, start.velocity)
        times = start.stamp + self.optimiser.horizon.times[1:]
        levels = tuple(
            self._objective(each, times) if isinstance(each, Track) else each for each in objectives
        )
        return self.optimiser.solve(start, levels, before, around)

    def _objective(self, track: Track, times: Vector) -> Objective:
        """Return a goal over the horizon."""
        if track.frame:
            check_tool(self.optimiser.robot, track.frame)
        return Objective(track.name, track.kind, track.reference(times))


def check_tool(robot: RobotModel, frame: str) -> None:
    """Raise InputError for a frame that is not the robot's default tool."""
    try:
        own, tool = (robot.pinocchio.frames[robot.frame(name)] for name in (frame, "tool"))
    except ModelError as error:
        raise InputError(f"track({frame!r}): {error}") from error
    if own.parentJoint != tool.parentJoint or not own.placement.isApprox(tool.placement):
        raise InputError(
            f"track({frame!r}): the MPC leads the robot's tool; build it with tool={frame!r}"
        )


def _row(value: Any) -> Vector:
    """Return a pose, or numbers, as a row of a reference."""
    if isinstance(value, Pose):
        return np.concatenate((value.position, to_quaternion(value.rotation)))
    return np.asarray(value, dtype=np.float64)
