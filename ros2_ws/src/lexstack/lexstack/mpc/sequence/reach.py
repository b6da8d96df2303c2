"""Which goals a robot can get to at all: kinematics and joint limits, floor and resting obstacles.

A task whose goal is out of reach is never done, and the tasks behind it never begin. So a sequence
is checked before it is taken. What is refused here cannot be met; what passes may still fail, as
nothing here plans a way.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc.sequence.task import SequenceTask
from lexstack.robots import Obstacles, Pose, RobotModel
from lexstack.robots.spatial import from_quaternions, log3
from lexstack.types import Vector

Place = tuple[float, float, float]  # of a base: x [m], y [m], yaw [rad]

_STARTS = 12  # configurations that the search begins at, the home first
_STEPS = 60  # per start
_STALLED = 1e-7  # of the squared error: a start that gains less per step has ended
# A goal is refused only if the least error found exceeds the tolerance by this much: at the border
# of the reach the search converges slowly.
_SLACK = 1e-3  # m, rad
_BASE = slice(0, 3)  # of a robot that drives, and no other has a Reach


class Reach:
    """The goals of tasks that one robot can meet."""

    def __init__(self, robot: RobotModel, obstacles: Obstacles) -> None:
        """Take a robot and what is in its way.

        Raises:
            InputError: the robot has no base, and so executes no sequences.
        """
        if robot.config.base is None:
            raise InputError(f"robot {robot.name}: has no base, and the MPC needs one")
        self._robot, self._platform = robot, robot.config.base
        still = obstacles.resting
        self._centers, self._radii = obstacles.at(0.0)[still], obstacles.radii[still]
        limits = robot.limits
        lower, upper = limits.position_lower, limits.position_upper
        home = robot.home((0.0, 0.0, 0.0))
        # Seeded: the same goal gets the same answer in every process and run.
        # A joint without limits is drawn from one turn.
        least = np.where(np.isfinite(lower), lower, -np.pi)[3:]
        most = np.where(np.isfinite(upper), upper, np.pi)[3:]
        drawn = np.random.default_rng(0).uniform(least, most, (_STARTS - 1, robot.n - 3))
        self._starts = np.vstack((home, np.hstack((np.zeros((_STARTS - 1, 3)), drawn))))
        self._lower, self._upper = lower, upper

    def check(
        self, tasks: Iterable[SequenceTask], architecture: str, base: Place | None = None
    ) -> None:
        """Raise InputError for the first task of a sequence whose goal cannot be met.

        Args:
            tasks: in their order.
            architecture: ``ht``: the whole robot serves every task; ``st``: the arm alone serves
                the tasks of the tool, from where the base tasks before have brought the base.
            base: where the base stands at the start; None: not known.
        """
        stands = base
        for task in tasks:
            apart = architecture == "st"
            why = self._unmet(task, stands if apart else None)
            if why:
                raise InputError(f"task {task.name!r}: points[{len(task.points) - 1}]: {why}")
            if task.kind == "base_pose":
                x, y, yaw = task.points[-1]
                stands = (x, y, yaw)
            elif task.kind == "base_position" and stands is not None:
                x, y = task.points[-1]
                stands = (x, y, stands[2])  # the yaw is nobody's task: it stays

    def _unmet(self, task: SequenceTask, base: Place | None) -> str:
        """Return why the goal of a task cannot be met, or ''; ``base``: where it must stay."""
        goal = np.array(task.points[-1])
        if task.kind.startswith("base"):
            return self._occupied(goal[:2])
        if goal[2] < -task.tolerance:
            return f"it is {-goal[2]:.2f} m below the floor"
        for center, radius in zip(self._centers, self._radii, strict=True):
            if np.linalg.norm(goal[:3] - center) + task.tolerance < radius:
                return "it is inside an obstacle"
        desired = goal[:3], np.eye(3)
        if task.kind == "ee_pose":
            # From one place of the base six equations stand against six or seven joints, and the
            # search may miss the way there. What it finds for the place of the tool alone, and for
            # the pose with a free base, is sure; both must be met.
            place = "" if base is None else self._missed(desired, task, base, turned=False)
            desired = goal[:3], from_quaternions(goal[None, 3:])[0]
            return place or self._missed(desired, task, None, turned=True)
        return self._missed(desired, task, base, turned=False)

    def _missed(
        self,
        desired: tuple[Vector, Vector],
        task: SequenceTask,
        base: Place | None,
        *,
        turned: bool,
    ) -> str:
        """Return by how much the tool misses a position and, if ``turned``, a rotation; or ''."""
        pose = Pose(*desired)
        allowed = (task.tolerance + _SLACK, task.tolerance_angle + _SLACK)
        distance, angle = self._least(pose, allowed, base, turned=turned)
        if distance < allowed[0] and angle < allowed[1]:
            return ""
        from_here = "" if base is None else f" with the base at ({base[0]:.2f}, {base[1]:.2f}) m"
        turn = f" and {angle:.2f} rad" if turned else ""
        return f"out of reach: the tool comes to {distance:.3f} m{turn} of it at best{from_here}"

    def _occupied(self, place: Vector) -> str:
        """Return why a base cannot stand at x, y [m], shape (2,), whatever its yaw; or ''."""
        base = self._platform
        inside = min(base.chassis_size[:2]) / 2.0  # a disc that the chassis covers at any yaw
        half = base.chassis_size[2] / 2.0
        for center, radius in zip(self._centers, self._radii, strict=True):
            above = max(abs(center[2] - base.chassis_height) - half, 0.0)
            if above >= radius:
                continue
            wide = np.sqrt(radius**2 - above**2)  # of the obstacle, at the chassis' height
            if np.linalg.norm(place - center[:2]) < wide + inside:
                return "an obstacle stands there"
        return ""

    def _least(
        self, desired: Pose, allowed: tuple[float, float], base: Place | None, *, turned: bool
    ) -> tuple[float, float]:
        """Return the least distance [m] and angle [rad] from a pose, of all starts.

        The search ends where both are ``allowed``. Levenberg and Marquardt's steps on the errors
        of position and, if ``turned``, orientation, cut at the joint limits.
        """
        best = (np.inf, np.inf)
        for start in self._starts:
            q = start.copy()
            if base is None:  # the tool begins above or below its goal
                q[:2] += (desired.position - self._robot.tool(q)[0].position)[:2]
            else:
                q[_BASE] = base
            found = self._descended(q, desired, allowed, free=base is None, turned=turned)
            if sum(found) < sum(best):
                best = found
            if found[0] < allowed[0] and found[1] < allowed[1]:
                break
        return best

    def _descended(
        self, q: Vector, desired: Pose, allowed: tuple[float, float], *, free: bool, turned: bool
    ) -> tuple[float, float]:
        """Return distance and angle that one start comes to; ``free``: whether the base moves."""
        rows = 6 if turned else 3
        damping, error, jacobian = 1e-3, *self._error(q, desired, rows)
        for _ in range(_STEPS):
            if not _exceeds(error, allowed):
                break
            square = float(error @ error)
            gradient = jacobian.T @ error
            moves = ~((q <= self._lower) & (gradient > 0.0) | (q >= self._upper) & (gradient < 0.0))
            moves[_BASE] &= free
            moving = jacobian[:, moves]
            normal = moving.T @ moving + damping * np.eye(moving.shape[1])
            step = np.zeros_like(q)
            step[moves] = -np.linalg.solve(normal, gradient[moves])
            trial = np.clip(q + step, self._lower, self._upper)
            next_error, next_jacobian = self._error(trial, desired, rows)
            gain = square - float(next_error @ next_error)
            if gain <= 0.0:
                damping *= 10.0
                if damping > 1e3:
                    break
                continue
            q, error, jacobian, damping = trial, next_error, next_jacobian, max(damping / 5.0, 1e-9)
            if gain < _STALLED * square:
                break
        return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))

    def _error(self, q: Vector, desired: Pose, rows: int) -> tuple[Vector, Vector]:
        """Return the error of the tool's pose, shape (rows,), and its slope, shape (rows, n)."""
        pose, jacobian = self._robot.tool(q)
        error = pose.position - desired.position
        if rows > 3:
            turn = log3(pose.rotation @ desired.rotation.T)
            error = np.concatenate((error, turn))
        return error, jacobian[:rows]


def _exceeds(error: Vector, allowed: tuple[float, float]) -> bool:
    """Return whether distance or angle is beyond what is allowed."""
    return bool(
        np.linalg.norm(error[:3]) >= allowed[0]
        or (len(error) > 3 and np.linalg.norm(error[3:]) >= allowed[1])
    )
