"""The lexicographic MPC as a program calls it: a configuration and goals in, a plan out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import lexstack.mpc
from lexstack.errors import InputError
from lexstack.mpc import (
    DEFAULT_HTMPC,
    CollisionScene,
    HtmpcConfig,
    Kind,
    Objective,
    OtherRobot,
    Plan,
    SequenceTask,
    Start,
)
from lexstack.references import TOOL
from lexstack.robots import Configuration, Pose, Robot, RobotModel, to_quaternion
from lexstack.tasks.specs.goals import is_motion, numbers, pose_from, shape_of
from lexstack.types import Vector


@dataclass(frozen=True, eq=False)
class Track:
    """A goal of the MPC: one level, H(7).

    Attributes:
        kind: what is led, see ``Objective``.
        goal: numbers as ``Objective`` has them in a row, or a trajectory.
        frame: which one an end-effector kind moves.
        joints: of ``joint_positions``; empty: all but the base's.
    """

    kind: Kind
    goal: Any
    frame: str = TOOL
    joints: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """What the plan's levels call it."""
        return self.kind + (f"({self.frame})" if self.kind.startswith("ee") else "")

    def objective(self, times: Vector) -> Objective:
        """Return it over a horizon, at times [s] of shape (N,)."""
        if is_motion(self.goal):
            rows = np.array([_row(self.goal.at(float(time))) for time in times])
        else:
            rows = np.tile(self.goal, (len(times), 1))
        return Objective(self.name, self.kind, rows, frame=self.frame, joints=self.joints)

    def task(self, name: str, **options: Any) -> SequenceTask:
        """Return it as a task of a sequence; ``options`` are those of ``SequenceTask``."""
        if is_motion(self.goal):
            raise InputError(f"task {name!r}: a sequence leads through points, not a trajectory")
        named = {"frame": self.frame, "joints": self.joints, **options}
        return SequenceTask(name, self.kind, (tuple(self.goal.tolist()),), **named)


def track(frame: str, goal: Any) -> Track:
    """Return the goal that leads a frame to a position, an orientation, or a pose.

    Args:
        frame: of the robot: a link or joint of its description, or ``tool``.
        goal: a position (3,) [m], a quaternion x y z w, a pose in any form that ``FramePose``
            takes, or a trajectory of poses over the time of the configuration; world frame.

    Raises:
        InputError: the goal has another form.
    """
    where = f"track({frame!r})"
    if is_motion(goal):
        return Track("ee_pose", goal, frame)
    if shape_of(goal) == (3,):
        return Track("ee_position", numbers(goal, (3,), where), frame)
    if shape_of(goal) == (4,):
        pose = pose_from((np.zeros(3), goal), where)
        return Track("ee_orientation", to_quaternion(pose.rotation), frame)
    return Track("ee_pose", _row(pose_from(goal, where)), frame)


def track_base(goal: Any) -> Track:
    """Return the goal that leads the base to x, y [m], or to x, y, yaw [m, m, rad].

    Args:
        goal: two or three numbers, or a trajectory of three; world frame.

    Raises:
        InputError: the goal has another form.
    """
    if is_motion(goal):
        return Track("base_pose", goal)
    size = 3 if shape_of(goal) == (3,) else 2
    kind: Kind = "base_pose" if size == 3 else "base_position"
    return Track(kind, numbers(goal, (size,), "track_base"))


def track_joints(goal: Any, joints: Sequence[str] = ()) -> Track:
    """Return the goal that leads joints to positions [rad, m].

    Args:
        goal: a number for each, or a trajectory of them.
        joints: their names; empty: all but the base's.

    Raises:
        InputError: the goal has another form.
    """
    size = (len(joints) or int(np.size(goal)),)
    row = goal if is_motion(goal) else numbers(goal, size, "track_joints")
    return Track("joint_positions", row, joints=tuple(joints))


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
            ModelError: the robot has a joint or a sphere that cannot be.
        """
        model = robot.model if isinstance(robot, Robot) else robot
        self.optimiser = lexstack.mpc.Htmpc(model, config, spheres)

    def solve(
        self,
        start: Configuration | Start,
        objectives: Sequence[Track | Objective],
        before: Plan | None = None,
        around: CollisionScene | None = None,
        others: Iterable[OtherRobot] = (),
    ) -> Plan:
        """Return the motion over the horizon that serves the goals in their order.

        Args:
            start: where the robot is; without a velocity it is at rest.
            objectives: the most important one first, by ``track``, ``track_base`` and
                ``track_joints``.
            before: the plan until now: a first guess.
            around: what is in the way.
            others: other robots, which are avoided where they will be.

        Raises:
            InputError: a goal does not fit the robot; what a solver does is in the plan.
        """
        if isinstance(start, Configuration):
            start = Start(start.time, start.q, start.velocity)
        times = start.stamp + self.optimiser.horizon.times[1:]
        levels = tuple(
            each.objective(times) if isinstance(each, Track) else each for each in objectives
        )
        return self.optimiser.solve(start, levels, before, around, others)


def _row(value: Any) -> Vector:
    """Return a pose, or numbers, as a row of a reference."""
    if isinstance(value, Pose):
        return np.concatenate((value.position, to_quaternion(value.rotation)))
    return np.asarray(value, dtype=np.float64)
