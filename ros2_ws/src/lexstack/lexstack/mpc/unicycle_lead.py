"""What a differential base follows over the horizon on its way to a reference.

A base that cannot go sideways has no direction in which it comes nearer to a place beside it: the
gradient of x^2 + y^2 + yaw^2 by (v, w) is zero there at rest, and a quadratic cost of the error
from the goal ends there, far off. So the cost of a base task is not that of the goal itself, but of
a motion that leads to it: the law of ``unicycle_law``, which has a proof, rolled out from the
measured state within the limits of speed and acceleration. Each solve begins it anew from there, so
it is a feedback. A reference that moves is followed by the tracking law of the same module, once it
is near.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.robots import RobotModel
from lexstack.robots.spatial import wrap
from lexstack.robots.unicycle import arc
from lexstack.tasks.unicycle_law import paced, tracking_rates
from lexstack.types import Matrix, Vector

_GAIN = 1.5  # 1/s, of both laws
_PARTS = 2  # of a stage, in each of which v and w are constant
# m: nearer than this a position is reached, and the base does not turn any more; below the 3 mm
# from which on the law for a pose turns to the yaw, so that a level below can do that.
_THERE = 2.5e-3
_NEAR, _AHEAD = 0.3, 1.0  # m, rad: from where on a moving reference is tracked
_MOVES = 0.01  # m/s: a reference that is slower stands


class UnicycleLead:
    """The motions of one robot's base over a horizon."""

    def __init__(self, robot: RobotModel, step: float) -> None:
        """Take its limits, and the length of a stage [s]."""
        speeds, rates = robot.limits.velocity[:2].tolist(), robot.limits.acceleration[:2].tolist()
        self._limits = ((speeds[0], speeds[1]), (rates[0], rates[1]))
        self._step = step

    def motion(self, q: Vector, v: Vector, goals: Matrix) -> tuple[Matrix, Matrix]:
        """Return the motion that leads to a reference.

        Args:
            q: the measured configuration; of it x [m], y [m], yaw [rad] count.
            v: the measured velocity; of it v [m/s], w [rad/s] count.
            goals: the reference at the states 1 to N: x, y or x, y, yaw, shape (N, 2) or (N, 3).

        Returns:
            x, y, yaw at the states 1 to N, shape (N, 3); and the inputs (v', w') that lead there
            but for what a stage's constant input cannot do, shape (N, 2).
        """
        pose, rates = q[:3], (float(v[0]), float(v[1]))
        poses, speeds = [], [rates]
        part = self._step / _PARTS
        for k, goal in enumerate(goals):
            change = (goals[max(k, 1)] - goals[max(k, 1) - 1]) / self._step
            for i in range(1, _PARTS + 1):
                aim = (
                    goal - (1.0 - i / _PARTS) * self._step * change if self._moves(change) else goal
                )
                rates = self._within(self._wanted(pose, aim, change), rates, part)
                pose = arc(pose, *rates, part)
            poses.append(pose)
            speeds.append(rates)
        return np.array(poses), np.diff(np.array(speeds), axis=0) / self._step

    def _moves(self, change: Vector) -> bool:
        """Return whether a reference goes somewhere; one that is faster than any base jumps."""
        speed = math.hypot(*change[:2].tolist())
        return bool(_MOVES < speed <= 1.2 * self._limits[0][0])

    def _wanted(self, pose: Vector, goal: Vector, change: Vector) -> tuple[float, float]:
        """Return v and w of the laws for a goal that changes at a rate."""
        x, y, yaw = pose.tolist()
        gap = float(goal[0]) - x, float(goal[1]) - y
        apart = math.hypot(*gap)
        if self._moves(change):
            along_x, along_y = change[:2].tolist()
            heading, turn = math.atan2(along_y, along_x), 0.0
            if math.cos(heading - yaw) < 0.0:
                heading += math.pi
            if len(goal) > 2:
                heading, turn = float(goal[2]), wrap(float(change[2]) * self._step) / self._step
            speed = along_x * math.cos(heading) + along_y * math.sin(heading)
            if apart < _NEAR and abs(wrap(heading - yaw)) < _AHEAD:
                return tracking_rates(gap, yaw, (heading, speed, turn), _GAIN)
        elif len(goal) > 2:
            return paced(gap, yaw, float(goal[2]), _GAIN, self._limits)
        if apart < _THERE:
            return 0.0, 0.0
        heading = math.atan2(gap[1], gap[0])
        if math.cos(heading - yaw) < 0.0:
            heading += math.pi
        return paced(gap, yaw, heading, _GAIN, self._limits)

    def _within(
        self, wanted: tuple[float, float], before: tuple[float, float], duration: float
    ) -> tuple[float, float]:
        """Return v and w shortened alike to the speeds, then changed as far as the limits allow."""
        speeds, accelerations = self._limits
        share = max(1.0, *(abs(one) / most for one, most in zip(wanted, speeds, strict=True)))
        v, w = (
            min(max(one / share, last - most * duration), last + most * duration)
            for one, last, most in zip(wanted, before, accelerations, strict=True)
        )
        return v, w
