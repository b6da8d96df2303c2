"""How near a frame of a robot comes to a pose: a search over its joints, and over its base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.robots import Pose, RobotModel
from lexstack.robots.spatial import log3
from lexstack.types import Matrix, Vector

Place = tuple[float, float, float]  # of a base: x [m], y [m], yaw [rad]

_STARTS = 12  # configurations that the search begins at, the home first
_STEPS = 60  # per start
_STALLED = 1e-7  # of the squared error: a start that gains less per step has ended


@dataclass(frozen=True, slots=True, eq=False)
class FrameGoal:
    """Where a frame is to be.

    Attributes:
        frame: as ``RobotModel.frame`` returned it.
        pose: in the world frame.
        rows: which of the six errors count, lengths before angles.
    """

    frame: int
    pose: Pose
    rows: slice

    def norms(self, error: Vector) -> tuple[float, float]:
        """Return distance and angle of an error, 0 for what does not count."""
        lengths = 3 - self.rows.start
        return float(np.linalg.norm(error[:lengths])), float(np.linalg.norm(error[lengths:]))


class ReachSearch:
    """The search for one robot.

    Attributes:
        lower: position limits in q, shape (n_q,); a base has none.
        upper: likewise.
    """

    def __init__(self, robot: RobotModel) -> None:
        """Draw the configurations that it begins at."""
        self._robot = robot
        limits, home = robot.limits, robot.home((0.0, 0.0, 0.0))
        self._base = robot.base_q
        free = np.full(self._base.stop, np.inf)
        self.lower = np.concatenate((-free, limits.position_lower[robot.arm]))
        self.upper = np.concatenate((free, limits.position_upper[robot.arm]))
        # Seeded: the same goal gets the same answer in every process and run.
        # A joint without limits is drawn from one turn.
        arm = robot.arm_q
        least = np.where(np.isfinite(self.lower), self.lower, -np.pi)[arm]
        most = np.where(np.isfinite(self.upper), self.upper, np.pi)[arm]
        drawn = np.random.default_rng(0).uniform(least, most, (_STARTS - 1, len(least)))
        bases = np.zeros((_STARTS - 1, len(free)))
        self._starts = np.vstack((home, np.hstack((bases, drawn))))

    def least(
        self, goal: FrameGoal, allowed: tuple[float, float], base: Place | None
    ) -> tuple[float, float]:
        """Return the least distance [m] and angle [rad] from a goal, of all starts.

        The search ends where both are ``allowed``. Levenberg and Marquardt's steps on the errors,
        cut at the joint limits; ``base``: where it must stay, None: anywhere.
        """
        best = (np.inf, np.inf)
        for start in self._starts:
            q = start.copy()
            if base is not None:
                q[self._base] = base[: self._base.stop]
            elif self._base.stop and goal.rows.start == 0:  # the frame begins above its goal
                q[:2] += (goal.pose.position - self._robot.at(q, goal.frame)[0].position)[:2]
            found = self._descended(q, goal, allowed, free=base is None)
            if sum(found) < sum(best):
                best = found
            if found[0] < allowed[0] and found[1] < allowed[1]:
                break
        return best

    def _descended(
        self, q: Vector, goal: FrameGoal, allowed: tuple[float, float], *, free: bool
    ) -> tuple[float, float]:
        """Return distance and angle that one start comes to; ``free``: whether the base moves."""
        damping, error, jacobian = 1e-3, *self._error(q, goal)
        for _ in range(_STEPS):
            distance, angle = goal.norms(error)
            if distance < allowed[0] and angle < allowed[1]:
                break
            square = float(error @ error)
            gradient = jacobian.T @ error
            moves = ~((q <= self.lower) & (gradient > 0.0) | (q >= self.upper) & (gradient < 0.0))
            moves[self._base] &= free
            moving = jacobian[:, moves]
            normal = moving.T @ moving + damping * np.eye(moving.shape[1])
            step = np.zeros_like(q)
            step[moves] = -np.linalg.solve(normal, gradient[moves])
            trial = np.clip(q + step, self.lower, self.upper)
            next_error, next_jacobian = self._error(trial, goal)
            gain = square - float(next_error @ next_error)
            if gain <= 0.0:
                damping *= 10.0
                if damping > 1e3:
                    break
                continue
            q, error, jacobian, damping = trial, next_error, next_jacobian, max(damping / 5.0, 1e-9)
            if gain < _STALLED * square:
                break
        return goal.norms(error)

    def _error(self, q: Vector, goal: FrameGoal) -> tuple[Vector, Matrix]:
        """Return the errors that count, shape (r,), and their slope, shape (r, n_q)."""
        pose, jacobian = self._robot.at(q, goal.frame)
        error = pose.position - goal.pose.position
        if goal.rows.stop > 3:
            turn = log3(pose.rotation @ goal.pose.rotation.T)
            error = np.concatenate((error, turn))
        if self._robot.differential:
            # By q: x and y move all of the robot, and what follows is as in chi.
            jacobian = np.hstack((np.eye(6, 2), jacobian[:, 1:]))
        return error[goal.rows], jacobian[goal.rows]
