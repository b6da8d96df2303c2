"""A goal of FollowJointTrajectory as values: what it asks for, and whether it is met."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.errors import InputError
from lexstack.robots import RobotModel
from lexstack.types import Vector
from lexstack_ros.messages.conversions import to_seconds, to_stamp

SUCCESSFUL, INVALID_GOAL, INVALID_JOINTS = 0, -1, -2
OLD_HEADER_TIMESTAMP, PATH_TOLERANCE_VIOLATED, GOAL_TOLERANCE_VIOLATED = -3, -4, -5
"""Codes of the action's result."""

_NEAR = 0.02  # rad, m: from the goal, where a goal says nothing
_PATIENCE = 2.0  # s after the end of a trajectory, where a goal says nothing


class GoalError(InputError):
    """A goal that cannot be, or was not met; ``code`` as in the action's result."""

    def __init__(self, code: int, text: str) -> None:
        """Keep both."""
        super().__init__(text)
        self.code = code


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far joints may be off, shape (n,) each, inf: without limit.

    Attributes:
        position: rad, m.
        velocity: rad/s, m/s.
    """

    position: Vector
    velocity: Vector

    @classmethod
    def of(
        cls, given: Iterable[Any], joints: Sequence[str], robot: str, default: float
    ) -> Tolerance:
        """Return what messages say: 0 stands for the default, less for no limit.

        Raises:
            GoalError: of a joint that is not one of the arm's, or not a number.
        """
        position, velocity = np.full(len(joints), default), np.full(len(joints), np.inf)
        for entry in given:
            name = entry.name.removeprefix(f"{robot}/")
            if name not in joints:
                raise GoalError(INVALID_JOINTS, f"tolerance of {entry.name!r:.80}: no such joint")
            for values, value in ((position, entry.position), (velocity, entry.velocity)):
                if np.isnan(value):
                    raise GoalError(INVALID_GOAL, f"tolerance of {name}: it is not a number")
                if value != 0.0:
                    values[list(joints).index(name)] = value if value > 0.0 else np.inf
        return cls(position, velocity)

    def exceeded(self, position: Vector, velocity: Vector, joints: Sequence[str]) -> str:
        """Return which joint is off by more, in words; '': none is."""
        for what, error, most in (
            ("", position, self.position),
            ("velocity ", velocity, self.velocity),
        ):
            beyond = np.flatnonzero(np.abs(error) > most)
            if len(beyond):
                i = int(beyond[0])
                return f"{joints[i]}: {what}off by {abs(error[i]):.4g}, at most {most[i]:.4g}"
        return ""


@dataclass(frozen=True, slots=True)
class JointGoal:
    """What a goal asks of an arm, checked but for its points.

    Attributes:
        joints: of the arm, in its own order.
        path: how closely the reference is to be followed.
        goal: how near the end is to be.
        last: positions at the end, shape (n,).
        begin: simulated time from which it holds [s].
        end: simulated time of the last point [s].
        patience: for the goal after the end [s].
    """

    joints: tuple[str, ...]
    path: Tolerance
    goal: Tolerance
    last: Vector
    begin: float
    end: float
    patience: float

    @classmethod
    def of(cls, goal: Any, model: RobotModel, now: float) -> JointGoal:
        """Return what a goal asks for at a time [s]; raises GoalError."""
        trajectory, joints = goal.trajectory, tuple(model.joints[model.arm])
        if goal.multi_dof_trajectory.points or goal.multi_dof_trajectory.joint_names:
            raise GoalError(INVALID_GOAL, "multi_dof_trajectory: the arm has no such joints")
        if goal.component_path_tolerance or goal.component_goal_tolerance:
            raise GoalError(INVALID_GOAL, "component tolerances: the arm has no such joints")
        if not trajectory.points:
            raise GoalError(INVALID_GOAL, "trajectory: it has no points")
        names = [name.removeprefix(f"{model.name}/") for name in trajectory.joint_names]
        if sorted(names) != sorted(joints):
            raise GoalError(INVALID_JOINTS, f"joint_names: expected {', '.join(joints)}")
        last = trajectory.points[-1]
        if len(last.positions) != len(joints):
            raise GoalError(INVALID_GOAL, "trajectory: points without positions")
        stamp = to_stamp(trajectory.header, "trajectory")
        begin = stamp or now
        end = begin + to_seconds(last.time_from_start)
        if stamp and end <= now:
            raise GoalError(
                OLD_HEADER_TIMESTAMP, f"it ended at {end:.3f} s, simulated time is {now:.3f} s"
            )
        leeway = to_seconds(goal.goal_time_tolerance)
        return cls(
            joints,
            Tolerance.of(goal.path_tolerance, joints, model.name, np.inf),
            Tolerance.of(goal.goal_tolerance, joints, model.name, _NEAR),
            np.array([last.positions[names.index(joint)] for joint in joints]),
            begin,
            end,
            leeway if leeway > 0.0 else np.inf if leeway < 0.0 else _PATIENCE,
        )

    def met(
        self, stamp: float, desired: tuple[Vector, Vector], actual: tuple[Vector, Vector]
    ) -> bool:
        """Return whether the goal is reached; raises GoalError where a tolerance is exceeded.

        Args:
            stamp: simulated time [s].
            desired: positions and velocities of the reference, shape (n,) each.
            actual: the measured ones.
        """
        (q, v), (wanted, rate) = actual, desired
        if self.begin <= stamp < self.end:
            off = self.path.exceeded(wanted - q, rate - v, self.joints)
            if off:
                raise GoalError(PATH_TOLERANCE_VIOLATED, f"on the way: {off}")
        if stamp < self.end:
            return False
        off = self.goal.exceeded(self.last - q, v, self.joints)
        if off and stamp > self.end + self.patience:
            raise GoalError(GOAL_TOLERANCE_VIOLATED, f"at the goal: {off}")
        return not off
